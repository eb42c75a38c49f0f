// The recorder of the journal, with a controller that only the test has.

#include "musher/view/record/journal_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/view/record/fake_sink.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::view::journal_recorder_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

msg::HistoryEntry EntryAt(std::int64_t wall_ns, std::uint64_t id) {
  msg::HistoryEntry entry;
  entry.wall_ns = wall_ns;
  entry.id = id;
  return entry;
}

TEST(JournalCursor, TakesEachEntryOnceAlsoThoseOfTheSameNanosecond) {
  JournalCursor cursor(100);
  EXPECT_THAT(cursor.Take({EntryAt(50, 1), EntryAt(100, 2), EntryAt(105, 3), EntryAt(110, 4)}),
              ElementsAre(2, 3));
  EXPECT_EQ(cursor.since_ns(), 109);
  EXPECT_THAT(cursor.Take({EntryAt(110, 4)}), IsEmpty());
  EXPECT_THAT(cursor.Take({EntryAt(110, 4), EntryAt(110, 5), EntryAt(120, 6)}), ElementsAre(1, 2));
}

TEST(JournalRecorder, RecordsWhatIsNewInTheJournalAndReportsItsEvents) {
  transport::sim::Network network(1);
  const auto dog = network.MakeNode("dog");
  const auto desk = network.MakeNode("desk");
  std::vector<msg::HistoryEntry> journal = {EntryAt(90, 1), EntryAt(110, 2)};
  const auto server = transport::MakeServer<msg::GetHistory>(
      *dog, "dog1/musher/get_history", [&journal](const auto& request, auto reply) {
        msg::GetHistory::Response answer;
        for (const msg::HistoryEntry& entry : journal) {
          if (entry.wall_ns <= request.since_wall_ns) continue;
          answer.entries.push_back(entry);
          answer.events.emplace_back("event_" + std::to_string(entry.id));
        }
        reply(answer);
      });
  ASSERT_TRUE(server);
  FakeSink sink;
  std::vector<std::string> events;
  const auto recorder = JournalRecorder::Make(
      *desk, "dog1", sink, 100, [&events](const std::string& event) { events.push_back(event); });
  ASSERT_TRUE(recorder);
  network.RunFor(std::chrono::seconds(5));
  journal.push_back(EntryAt(200, 3));
  network.RunFor(std::chrono::seconds(5));
  EXPECT_THAT(events, ElementsAre("event_2", "event_3"));
  ASSERT_THAT(sink.samples, SizeIs(2));
  EXPECT_EQ(sink.channels[0].topic, "/dog1/musher/journal");
  EXPECT_EQ(sink.samples[1].log_ns, 200);
  EXPECT_EQ(sink.samples[1].data, msg::Encode(EntryAt(200, 3)));
}

}  // namespace musher::view::journal_recorder_test
