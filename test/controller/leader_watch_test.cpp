// A client follows one machine: by its identity, not by the epochs of whatever controllers answer.

#include "musher/controller/client/leader_watch.hpp"

#include <gmock/gmock.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::leader_watch_test {

using std::chrono::seconds;
using ::testing::ElementsAre;

class LeaderWatches : public ::testing::Test {
 protected:
  // The controller of a machine: a process that latches the machine's status.
  struct Controller {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::MachineStatus>> status;
  };
  Controller Leads(const std::string& machine, const std::string& id, std::uint64_t epoch,
                   std::int32_t pid, std::uint64_t participant = 0,
                   const std::string& host = "here") {
    Controller controller{network_.MakeNode(machine + std::to_string(pid)), nullptr};
    controller.status =
        transport::MakePublisher<msg::MachineStatus>(
            *controller.node, transport::MachineStatusTopic(""), transport::kLatchedQos)
            .value();
    msg::MachineStatus status;
    status.machine = machine;
    status.machine_id = id;
    status.epoch = epoch;
    status.pid = pid;
    status.host = host;
    status.participant = participant;
    EXPECT_TRUE(controller.status->Publish(status));
    network_.RunFor(Milliseconds(100));
    return controller;
  }
  // The kernel reports the exit at once; the network still delivers what the process had latched.
  void ReportExit(std::int32_t pid) {
    const auto watcher = watchers_.extract(pid);
    if (!watcher.empty()) watcher.mapped()();
  }
  void Watch(const MachineIdentity& machine = {}) {
    LeaderWatch::Options options = OptionsHere();
    options.machine = machine;
    Begin(options);
  }
  // As the page does.
  void WatchAsAPage(const std::string& word = "") {
    LeaderWatch::Options options = OptionsHere();
    options.one_name = true;
    options.prefer_here = true;
    options.word = word;
    Begin(options);
  }
  LeaderWatch::Options OptionsHere() {
    return {"", "here",
            [this](std::int32_t pid, std::function<void()> on_end) -> transport::LoopHandlePtr {
              if (pid == kExited) return nullptr;
              watchers_[pid] = std::move(on_end);
              return std::make_unique<transport::LoopHandle>();
            }};
  }
  void Begin(const LeaderWatch::Options& options) {
    watch_ = LeaderWatch::Make(
                 *desk_, options,
                 [this](const msg::MachineStatus& status) { taken_.push_back(status.pid); },
                 [this](const msg::MachineStatus&, const std::string& how) {
                   ends_.push_back(how);
                   ended_at_ = network_.now();
                 })
                 .value();
  }

  // Of the machine "dog", whose controller runs elsewhere with that pid.
  void Heartbeat(transport::Node& from, std::int32_t pid, std::uint64_t participant,
                 Duration period = Milliseconds(125)) {
    auto publisher = transport::MakePublisher<msg::ControllerHeartbeat>(
                         from, transport::ControllerHeartbeatTopic(""), transport::kLatchedQos)
                         .value();
    msg::ControllerHeartbeat heartbeat;
    heartbeat.machine = "dog";
    heartbeat.host = "elsewhere";
    heartbeat.pid = pid;
    heartbeat.period_ns = period.count();
    heartbeat.participant = participant;
    EXPECT_TRUE(publisher->Publish(heartbeat));
    network_.RunFor(Milliseconds(100));
    heartbeats_.push_back(std::move(publisher));
  }

  static constexpr std::int32_t kExited = 9;  // a process that has exited

  transport::sim::Network network_{1};
  std::vector<std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>>> heartbeats_;
  std::vector<std::string> ends_;  // how each leader has ended
  Time ended_at_{};                // the last one
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::map<std::int32_t, std::function<void()>> watchers_;
  std::vector<std::int32_t> taken_;  // pids of the controllers
  std::unique_ptr<LeaderWatch> watch_;
};

TEST_F(LeaderWatches, TakeALaterControllerOfTheMachineWithALowerEpoch) {
  Watch();
  const auto killed = Leads("dog", "uuid-a", 7, 1);
  ReportExit(1);
  const auto successor = Leads("dog", "uuid-a", 1, 2);
  EXPECT_THAT(taken_, ElementsAre(1, 2));
  ASSERT_TRUE(watch_->leader());
  EXPECT_EQ(watch_->leader()->pid, 2);
}

TEST_F(LeaderWatches, TakeAnotherMachineWithALowerEpochOnceTheirsHasEnded) {
  Watch();
  const auto killed = Leads("dog", "uuid-a", 7, 1);
  ReportExit(1);
  const auto other = Leads("cat", "uuid-b", 1, 2);
  EXPECT_THAT(taken_, ElementsAre(1, 2));
}

TEST_F(LeaderWatches, StayWithTheirMachineWhileAnotherHasAHigherEpoch) {
  Watch();
  const auto dog = Leads("dog", "uuid-a", 7, 1);
  const auto cat = Leads("cat", "uuid-b", 9, 2);
  EXPECT_THAT(taken_, ElementsAre(1));
}

TEST_F(LeaderWatches, TakeTheMachineThatIsMeantOnly) {
  Watch({"cat", ""});
  const auto dog = Leads("dog", "uuid-a", 7, 1);
  const auto cat = Leads("cat", "uuid-b", 2, 2);
  EXPECT_THAT(taken_, ElementsAre(2));
  ReportExit(2);
  const auto later = Leads("dog", "uuid-a", 8, 3);
  EXPECT_THAT(taken_, ElementsAre(2));
}

TEST_F(LeaderWatches, IgnoreAnOlderControllerOfTheirMachine) {
  Watch();
  const auto present = Leads("dog", "uuid-a", 7, 1);
  const auto older = Leads("dog", "uuid-a", 6, 2);
  EXPECT_THAT(taken_, ElementsAre(1));
}

TEST_F(LeaderWatches, PreferTheMachineOfTheirHostToTheFirstAndStayWithIt) {
  WatchAsAPage();
  const auto cat = Leads("cat", "uuid-b", 9, 2, 0, "elsewhere");
  const auto dog = Leads("dog", "uuid-a", 1, 1);
  EXPECT_THAT(taken_, ElementsAre(2, 1));
  ReportExit(1);
  const auto bear = Leads("bear", "uuid-c", 3, 3, 0, "elsewhere");
  EXPECT_THAT(taken_, ElementsAre(2, 1)) << "another robot that comes near is not theirs";
  const auto again = Leads("dog", "uuid-a", 2, 4);
  EXPECT_THAT(taken_, ElementsAre(2, 1, 4));
}

// A robot beside it, which publishes while the first one's heartbeat is lost, or is switched on
// later.
TEST_F(LeaderWatches, StayWithTheOneMachineThatTheyHaveFoundAlsoAfterItsEnd) {
  WatchAsAPage();
  std::optional dog(Leads("dog", "uuid-a", 7, 1, 0, "elsewhere"));
  dog.reset();
  network_.RunFor(seconds(20));
  ASSERT_FALSE(watch_->leader());
  const auto cat = Leads("cat", "uuid-b", 9, 2, 0, "elsewhere");
  EXPECT_THAT(taken_, ElementsAre(1));
  EXPECT_EQ(watch_->machine(), (MachineIdentity{"dog", "uuid-a"}));
  const auto again = Leads("dog", "uuid-a", 8, 3, 0, "elsewhere");
  EXPECT_THAT(taken_, ElementsAre(1, 3));
}

TEST_F(LeaderWatches, TakeTheirMachineAgainAfterItsStateFolderWasLost) {
  WatchAsAPage();
  std::optional dog(Leads("dog", "uuid-a", 7, 1, 0, "elsewhere"));
  const auto copy = Leads("dog", "uuid-c", 8, 2, 0, "elsewhere");
  EXPECT_THAT(taken_, ElementsAre(1)) << "while the first one leads, by its id";
  dog.reset();
  network_.RunFor(seconds(20));
  const auto again = Leads("dog", "uuid-d", 1, 3, 0, "elsewhere");
  EXPECT_THAT(taken_, ElementsAre(1, 3));
}

TEST_F(LeaderWatches, TakeNoMachineOfAnotherHostOnceTheyHaveFoundTheirs) {
  WatchAsAPage();
  const auto dog = Leads("dog", "uuid-a", 1, 1);
  ReportExit(1);
  const auto copy = Leads("dog", "uuid-c", 8, 2, 0, "elsewhere");
  EXPECT_THAT(taken_, ElementsAre(1));
}

TEST_F(LeaderWatches, TakeTheMachineOfTheirHostAlsoAfterTheEndOfTheOneThatTheyHaveFound) {
  WatchAsAPage();
  std::optional cat(Leads("cat", "uuid-b", 9, 2, 0, "elsewhere"));
  cat.reset();
  network_.RunFor(seconds(20));
  ASSERT_FALSE(watch_->leader());
  EXPECT_FALSE(watch_->found_here());
  const auto dog = Leads("dog", "uuid-a", 1, 1);
  EXPECT_THAT(taken_, ElementsAre(2, 1));
  EXPECT_TRUE(watch_->found_here());
}

TEST_F(LeaderWatches, TakeTheNextMachineOfTheirHostOnceTheirsHasEnded) {
  WatchAsAPage();
  const auto dog = Leads("dog", "uuid-a", 1, 1);
  ReportExit(1);
  const auto next = Leads("cat", "uuid-b", 1, 2);
  EXPECT_THAT(taken_, ElementsAre(1, 2));
}

TEST_F(LeaderWatches, TakeTheMachineWhoseIdBeginsWithTheWordOfAPerson) {
  WatchAsAPage("5982");
  EXPECT_EQ(watch_->machine(), (MachineIdentity{"5982", ""}));
  const auto cat = Leads("cat", "11112222-b", 7, 1, 0, "elsewhere");
  const auto dog = Leads("dog", "5982c7ee-a", 2, 2, 0, "elsewhere");
  EXPECT_THAT(taken_, ElementsAre(2));
  EXPECT_EQ(watch_->machine(), (MachineIdentity{"dog", "5982c7ee-a"}));
}

TEST_F(LeaderWatches, ListTheMachinesThatTheWordOfAPersonMayMean) {
  WatchAsAPage("dog");
  const auto cat = Leads("cat", "uuid-b", 7, 1, 0, "elsewhere");
  const auto dog = Leads("dog", "uuid-a", 2, 2, 0, "elsewhere");
  const auto successor = Leads("dog", "uuid-a", 3, 3, 0, "elsewhere");
  const auto copy = Leads("dog", "uuid-c", 1, 4, 0, "elsewhere");
  EXPECT_THAT(watch_->candidates(),
              ElementsAre(MachineIdentity{"dog", "uuid-a"}, MachineIdentity{"dog", "uuid-c"}));
}

TEST_F(LeaderWatches, IgnoreAStatusThatAnotherParticipantRepeats) {
  Watch();
  const auto present = Leads("dog", "uuid-a", 7, 1);
  const std::uint64_t recorded = 4711;  // the participant that has sent it first
  const auto replayed = Leads("dog", "uuid-a", 8, 2, recorded);
  EXPECT_THAT(taken_, ElementsAre(1));
}

TEST_F(LeaderWatches, KeepTheirControllerBesideTheStatusOfAProcessThatHasExited) {
  Watch();
  const auto present = Leads("dog", "uuid-a", 7, 1);
  const auto of_no_process = Leads("dog", "uuid-a", 7, kExited);
  EXPECT_THAT(taken_, ElementsAre(1));
  EXPECT_TRUE(watch_->leader());
}

TEST_F(LeaderWatches, TakeNoExitedControllerAgainByItsLatchedStatus) {
  Watch();
  const auto killed = Leads("dog", "uuid-a", 7, 1);
  ReportExit(1);
  msg::MachineStatus status;
  status.machine = "dog";
  status.epoch = 7;
  status.pid = 1;
  status.host = "here";
  EXPECT_TRUE(killed.status->Publish(status));  // was on its way
  network_.RunFor(seconds(1));
  EXPECT_THAT(taken_, ElementsAre(1));
  EXPECT_FALSE(watch_->leader());
}

TEST_F(LeaderWatches, TakeNoProcessOfTheirHostThatHasExited) {
  Watch();
  const auto of_no_process = Leads("dog", "uuid-a", 7, kExited);
  EXPECT_THAT(taken_, ::testing::IsEmpty());
  EXPECT_THAT(ends_, ElementsAre("has exited"));
  EXPECT_FALSE(watch_->leader());
}

TEST_F(LeaderWatches, TakeASuccessorWithTheSameEpoch) {
  Watch();
  const auto first = Leads("dog", "uuid-a", 7, 1);
  const auto second = Leads("dog", "uuid-a", 7, 2);
  EXPECT_THAT(taken_, ElementsAre(1, 2));
}

TEST_F(LeaderWatches, LoseTheirControllerWithTheWriterOfItsStatus) {
  Watch();
  auto present = Leads("dog", "uuid-a", 7, 1);
  present.status.reset();
  network_.RunFor(Milliseconds(200));
  EXPECT_THAT(ends_, ElementsAre("no longer leads"));
  EXPECT_FALSE(watch_->leader());
}

// Its exit is not known: it may have withdrawn its status only.
TEST_F(LeaderWatches, TakeAControllerAgainThatNoLongerLed) {
  Watch();
  const auto first = Leads("dog", "uuid-a", 7, 1);
  const auto second = Leads("dog", "uuid-a", 8, 2, 0, "elsewhere");
  network_.RunFor(seconds(3));  // it is silent
  msg::MachineStatus status;
  status.machine = "dog";
  status.epoch = 9;
  status.pid = 1;
  status.host = "here";
  EXPECT_TRUE(first.status->Publish(status));
  network_.RunFor(seconds(1));
  EXPECT_THAT(taken_, ElementsAre(1, 2, 1));
}

TEST_F(LeaderWatches, LoseASilentControllerOfAnotherHostAndTakeItAgainByItsHeartbeat) {
  Watch();
  const auto remote = Leads("dog", "uuid-a", 7, 1, 0, "elsewhere");
  Heartbeat(*remote.node, 1, 0);
  const Time last = network_.now();
  network_.RunFor(seconds(3));
  EXPECT_THAT(ends_, ElementsAre("sends no heartbeat"));
  EXPECT_GE(ended_at_ - last, Milliseconds(600)) << "a heartbeat may be lost";
  EXPECT_LE(ended_at_ - last, Milliseconds(800));
  Heartbeat(*remote.node, 1, 0);
  EXPECT_THAT(taken_, ElementsAre(1, 1));
  EXPECT_TRUE(watch_->leader());
}

TEST_F(LeaderWatches, WaitForAsLongAsTheHeartbeatsOfTheirControllerTake) {
  Watch();
  const auto remote = Leads("dog", "uuid-a", 7, 1, 0, "elsewhere");
  Heartbeat(*remote.node, 1, 0, seconds(1));
  network_.RunFor(seconds(3));
  EXPECT_THAT(ends_, ::testing::IsEmpty());
  network_.RunFor(seconds(2));
  EXPECT_THAT(ends_, ElementsAre("sends no heartbeat"));
}

TEST_F(LeaderWatches, DoNotWaitForHeartbeatsThatAnotherParticipantRepeats) {
  Watch();
  const auto remote = Leads("dog", "uuid-a", 7, 1, 0, "elsewhere");
  const auto bridge = network_.MakeNode("bridge");
  for (int i = 0; i < 40; ++i) Heartbeat(*bridge, 1, remote.node->participant().value());
  EXPECT_THAT(ends_, ElementsAre("sends no heartbeat"));
}

}  // namespace musher::testing::leader_watch_test
