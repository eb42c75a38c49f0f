// The recorder of the journal, with a controller that only the test has.

#include "musher/view/record/journal_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/view/record/fake_sink.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::view::journal_recorder_test {

using ::testing::ElementsAre;
using ::testing::SizeIs;

msg::HistoryEntry EntryAt(std::int64_t wall_ns, std::uint64_t id) {
  msg::HistoryEntry entry;
  entry.wall_ns = wall_ns;
  entry.id = id;
  return entry;
}

// A machine of the namespace dog1 that only reports that it runs and what its journal has.
class FakeMachine {
 public:
  FakeMachine(transport::sim::Network& network, const std::string& name) {
    node_ = network.MakeNode(name);
    server_ = transport::MakeServer<msg::GetHistory>(
                  *node_, "dog1/musher/get_history",
                  [this, name](const auto& request, auto reply) {
                    msg::GetHistory::Response answer;
                    if (!request.machine.empty() && request.machine != name) return reply(answer);
                    for (const msg::HistoryEntry& entry : journal) {
                      if (entry.wall_ns <= request.since_wall_ns) continue;
                      answer.entries.push_back(entry);
                      answer.events.emplace_back("event_" + std::to_string(entry.id));
                    }
                    reply(answer);
                  })
                  .value();
    statuses_ = transport::MakePublisher<msg::MachineStatus>(*node_, "dog1/musher/machine_status",
                                                             transport::kLatchedQos)
                    .value();
    status.machine = name;
    status.machine_id = name + "-id";
    Report();
  }
  void Report() { EXPECT_TRUE(statuses_->Publish(status)); }

  std::vector<msg::HistoryEntry> journal;
  msg::MachineStatus status;

 private:
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Server<msg::GetHistory>> server_;
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> statuses_;
};

class JournalOfAMachine : public ::testing::Test {
 protected:
  void Record() {
    recorder_ = JournalRecorder::Make(
                    *desk_, "dog1", "desk", sink_, 100,
                    {[this](const std::string& event) { events_.push_back(event); },
                     [this](const msg::MachineStatus& status) { states_.push_back(status.state); }})
                    .value();
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  FakeSink sink_;
  std::vector<std::string> events_;
  std::vector<std::string> states_;
  std::unique_ptr<JournalRecorder> recorder_;
};

TEST_F(JournalOfAMachine, IsRecordedAsFarAsItIsNewAndItsEventsAreReported) {
  FakeMachine dog(network_, "dog");
  dog.journal = {EntryAt(90, 1), EntryAt(110, 2)};
  Record();
  network_.RunFor(std::chrono::seconds(5));
  dog.journal.push_back(EntryAt(200, 3));
  dog.Report();
  network_.RunFor(std::chrono::seconds(5));
  EXPECT_THAT(events_, ElementsAre("event_2", "event_3"));
  ASSERT_THAT(sink_.samples, SizeIs(2));
  EXPECT_EQ(sink_.channels[0].topic, "/dog1/musher/journal");
  EXPECT_EQ(sink_.samples[1].log_ns, 200);
  EXPECT_EQ(sink_.samples[1].data, msg::Encode(EntryAt(200, 3)));
}

// Nothing more was recorded until the clock had caught up.
TEST_F(JournalOfAMachine, IsRecordedOnWhenTheWallClockIsSetBack) {
  FakeMachine dog(network_, "dog");
  dog.journal = {EntryAt(110, 1)};
  Record();
  network_.RunFor(std::chrono::seconds(5));
  dog.journal.push_back(EntryAt(20, 2));
  dog.Report();
  network_.RunFor(std::chrono::seconds(5));
  EXPECT_THAT(events_, ElementsAre("event_1", "event_2"));
}

// The journals of both machines were in the file, and the status of each was trouble for the other.
TEST_F(JournalOfAMachine, IsNotMixedWithThatOfAnotherMachineOfTheNamespace) {
  FakeMachine dog(network_, "dog");
  dog.journal = {EntryAt(110, 1)};
  dog.status.state = "Active";
  dog.Report();
  Record();
  network_.RunFor(std::chrono::seconds(1));
  FakeMachine cat(network_, "cat");
  cat.journal = {EntryAt(120, 2)};
  cat.status.state = "Error";
  cat.Report();
  for (int i = 0; i < 10; ++i) {
    dog.Report();
    network_.RunFor(std::chrono::seconds(1));
  }
  EXPECT_THAT(events_, ElementsAre("event_1"));
  EXPECT_THAT(states_, ::testing::Each("Active"));
}

}  // namespace musher::view::journal_recorder_test
