// In virtual time: what a page gets of the history of a controller that only the test has, and that
// sends no heartbeat: after two seconds it is lost.

#include "musher/view/live/machine_feed.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view::machine_feed_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class HistoryOfAPage : public ::testing::Test {
 protected:
  void SetUp() override {
    server_ =
        transport::MakeServer<msg::GetHistory>(
            *robot_, transport::MachineService("", "get_history"),
            [this](const msg::GetHistory::Request& request, auto reply) { reply(Newest(request)); })
            .value();
    statuses_ = transport::MakePublisher<msg::MachineStatus>(
                    *robot_, transport::MachineStatusTopic(""), transport::kLatchedQos)
                    .value();
    Report();
    feed_ = MachineFeed::Make(*desk_, {"", "desk", ""},
                              {[](const auto&, const auto&) {},
                               [this](const std::vector<SharedText>& entries) {
                                 received_.insert(received_.end(), entries.begin(), entries.end());
                               },
                               [] {}})
                .value();
    network_.RunFor(Milliseconds(200));
    ASSERT_TRUE(feed_->status()) << "the page follows no controller";
    feed_->SetOpenPages(1);
    network_.RunFor(Milliseconds(200));
    ASSERT_THAT(limits_, Not(IsEmpty())) << "the page asks for no history";
  }

  void Report() {
    msg::MachineStatus status;
    status.machine = "dog";
    status.host = "robot";
    EXPECT_TRUE(statuses_->Publish(status).ok());
  }
  void Record(std::uint64_t id, std::int64_t wall_ns) {
    msg::HistoryEntry entry;
    entry.id = id;
    entry.wall_ns = wall_ns;
    journal_.push_back(entry);
  }
  msg::GetHistory::Response Newest(const msg::GetHistory::Request& request) {
    limits_.push_back(request.limit);
    msg::GetHistory::Response answer;
    std::ranges::copy_if(journal_, std::back_inserter(answer.entries),
                         [&](const auto& entry) { return entry.wall_ns >= request.since_wall_ns; });
    const std::size_t count = answer.entries.size();
    const std::size_t too_many = count - std::min<std::size_t>(count, request.limit);
    answer.entries.erase(answer.entries.begin(),
                         answer.entries.begin() + static_cast<std::ptrdiff_t>(too_many));
    return answer;
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::vector<msg::HistoryEntry> journal_;
  std::vector<std::uint32_t> limits_;  // of the requests
  std::vector<SharedText> received_;
  std::unique_ptr<transport::Server<msg::GetHistory>> server_;
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> statuses_;
  std::unique_ptr<MachineFeed> feed_;
};

// The page showed nothing that happened until the clock had caught up.
TEST_F(HistoryOfAPage, GoesOnWhenTheWallClockIsSetBack) {
  Record(1, 1000);
  Report();
  network_.RunFor(Milliseconds(200));
  ASSERT_THAT(received_, SizeIs(1));
  Record(2, 10);
  Report();
  network_.RunFor(Milliseconds(200));
  ASSERT_THAT(received_, SizeIs(2));
  EXPECT_THAT(*received_.back(), ::testing::HasSubstr(R"("id":2)"));
}

TEST_F(HistoryOfAPage, HasTheNewestEntriesOfAFlood) {
  for (std::uint64_t id = 1; id <= 1000; ++id) Record(id, 7);
  limits_.clear();
  Report();
  network_.RunFor(Milliseconds(200));
  EXPECT_THAT(received_, SizeIs(MachineFeed::kKeptEntries));
  EXPECT_THAT(limits_, ElementsAre(JournalCursor::kNextEntries, 10 * JournalCursor::kNextEntries,
                                   MachineFeed::kKeptEntries));
}

}  // namespace musher::view::machine_feed_test
