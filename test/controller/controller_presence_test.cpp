// A controller whose process was stopped starts no process before it has listened for another one,
// which may have started them on its host.

#include "musher/controller/shell/controller_presence.hpp"

#include <gtest/gtest.h>

#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::controller_presence_test {

using std::chrono::seconds;

class StoppedController : public ::testing::Test {
 protected:
  // It leads for 2 s, is stopped for `duration`, and continues.
  Duration WaitAfterStopOf(Duration duration, TransportProfile profile,
                           const std::string& keys = "") {
    config_.transport = profile;
    config_.keys = keys;
    presence_ =
        ControllerPresence::Make(*node_, config_, {1, 1, "here"}, [](const Event&) {}).value();
    presence_->Announce(1);
    network_.RunFor(seconds(2));
    network_.Pause(node_->simulated());
    network_.RunFor(duration);
    network_.Resume(node_->simulated());
    return Wait();
  }
  Duration Wait() {
    const Time now = node_->loop().Now();
    return std::max(presence_->MayStartProcessesAt(), now) - now;
  }

  transport::sim::Network network_{1};
  MachineConfig config_ = MachineOf(2);
  std::unique_ptr<SuspendedNode> node_ = std::make_unique<SuspendedNode>(network_.MakeNode("here"));
  std::unique_ptr<ControllerPresence> presence_;
};

TEST_F(StoppedController, ListensBeforeItStartsAProcess) {
  EXPECT_EQ(WaitAfterStopOf(seconds(9), TransportProfile::kLan), seconds(1));
  network_.RunFor(Milliseconds(400));
  EXPECT_EQ(Wait(), Milliseconds(600));
  network_.RunFor(seconds(2));
  EXPECT_EQ(Wait(), Duration{});
}

TEST_F(StoppedController, ListensAsLongAsDiscoveryWithCredentialsMayTake) {
  EXPECT_EQ(WaitAfterStopOf(seconds(9), TransportProfile::kLan, "/keys"), seconds(4));
}

TEST_F(StoppedController, DoesNotListenAfterABreakTooShortForATakeover) {
  EXPECT_EQ(WaitAfterStopOf(Milliseconds(400), TransportProfile::kLan), Duration{});
}

// The loop's time stands meanwhile.
TEST_F(StoppedController, ListensAfterItsComputerWasSuspended) {
  config_.transport = TransportProfile::kLan;
  presence_ =
      ControllerPresence::Make(*node_, config_, {1, 1, "here"}, [](const Event&) {}).value();
  presence_->Announce(1);
  network_.RunFor(seconds(2));
  EXPECT_EQ(Wait(), Duration{});
  node_->loop().suspended = seconds(9);
  EXPECT_EQ(Wait(), seconds(1));
  network_.RunFor(seconds(2));
  EXPECT_EQ(Wait(), Duration{}) << "once for each suspension";
}

// The lock on the machine's name excludes another controller on the same host.
TEST_F(StoppedController, DoesNotListenWhereOnlyThisHostRunsControllers) {
  EXPECT_EQ(WaitAfterStopOf(seconds(9), TransportProfile::kLocal), Duration{});
}

// What waited meanwhile, or is repeated, arrives in the two seconds after it.
TEST_F(StoppedController, CountsABreakOfMoreThanFiveSecondsForTwoSeconds) {
  WaitAfterStopOf(seconds(9), TransportProfile::kLocal);
  const auto could_not_run = presence_->RecentBreak();
  ASSERT_TRUE(could_not_run);
  EXPECT_GT(*could_not_run, Milliseconds(8900));
  EXPECT_LT(*could_not_run, seconds(10));
  network_.RunFor(Milliseconds(1900));
  EXPECT_TRUE(presence_->RecentBreak());
  network_.RunFor(Milliseconds(200));
  EXPECT_FALSE(presence_->RecentBreak());
}

TEST_F(StoppedController, CountsNoShorterBreak) {
  WaitAfterStopOf(seconds(4), TransportProfile::kLan);
  EXPECT_FALSE(presence_->RecentBreak());
}

TEST_F(StoppedController, CountsTheTimeForWhichItsComputerWasSuspended) {
  presence_ =
      ControllerPresence::Make(*node_, config_, {1, 1, "here"}, [](const Event&) {}).value();
  EXPECT_FALSE(presence_->RecentBreak()) << "it has not led yet";
  presence_->Announce(1);
  network_.RunFor(seconds(2));
  EXPECT_FALSE(presence_->RecentBreak());
  node_->loop().suspended = std::chrono::hours(8);
  EXPECT_GE(presence_->RecentBreak(), std::chrono::hours(8));
  network_.RunFor(seconds(3));
  EXPECT_FALSE(presence_->RecentBreak());
}

TEST_F(StoppedController, CountsNoTimeInWhichItIsSilentOnPurpose) {
  WaitAfterStopOf(Milliseconds(1), TransportProfile::kLan);
  presence_->FallSilent();
  network_.RunFor(seconds(9));
  EXPECT_FALSE(presence_->RecentBreak());
}

class Rivals : public ::testing::Test {
 protected:
  // How the controller on `here` names the one on another host.
  std::string NameOf(const ControllerPresence::Identity& other) {
    const auto there = network_.MakeNode("there");
    const auto ours = Presence(*here_, {1, 1, "boot-a/1", "dog"});
    const auto theirs = Presence(*there, other);
    ours->Announce(1);
    theirs->Announce(2);
    network_.RunFor(seconds(2));
    return ours->rival() ? ours->rival()->process : "";
  }

 private:
  std::unique_ptr<ControllerPresence> Presence(transport::Node& node,
                                               const ControllerPresence::Identity& identity) {
    return ControllerPresence::Make(node, config_, identity, [](const Event&) {}).value();
  }

  transport::sim::Network network_{1};
  MachineConfig config_ = MachineOf(2);
  std::unique_ptr<transport::Node> here_ = network_.MakeNode("here");
};

TEST_F(Rivals, AreKnownByTheNameOfTheirHost) {
  EXPECT_EQ(NameOf({1, 7, "boot-b/1", "cat"}), "process 7 of host cat");
  EXPECT_EQ(NameOf({1, 7, "boot-a/1", "dog"}), "process 7 of this host");
}

TEST_F(Rivals, OfAnOlderVersionAreKnownByAShortIdThatIsExplained) {
  EXPECT_EQ(NameOf({1, 7, "5982c7ee-4f4e-4b5c-9f5e/4026531836", ""}),
            "process 7 of another host (boot id 5982c7ee…)");
}

// What a controller receives before it leads.
class Releases : public ::testing::Test {
 protected:
  Releases() {
    presence_ = Presence(*here_, [this](const Event& event) {
      const auto* stop = std::get_if<event::EmergencyStopSeen>(&event);
      if (stop != nullptr) seen_.emplace_back(stop->engaged ? "engaged" : "released");
    });
  }

  std::unique_ptr<ControllerPresence> Presence(transport::Node& node,
                                               const ControllerPresence::Emit& emit) {
    const std::string host = "boot/" + std::to_string(++hosts_);
    return ControllerPresence::Make(node, config_, {1, 7, host}, emit).value();
  }
  void Publish(transport::Node& node, bool engaged) {
    auto made = transport::MakePublisher<msg::EmergencyStop>(
        node, transport::EmergencyStopTopic(config_.name_space),
        {transport::Qos::Reliability::kReliable, transport::Qos::Durability::kTransientLocal, 8});
    publishers_.push_back(std::move(made).value());
    network_.RunFor(seconds(1));  // until it is discovered
    ASSERT_TRUE(publishers_.back()->Publish({5, engaged, "the panel", "", config_.name, ""}));
    network_.RunFor(seconds(1));
  }

  using Seen = std::vector<std::string>;
  transport::sim::Network network_{1};
  MachineConfig config_ = MachineOf(2);
  int hosts_ = 0;
  Seen seen_;
  std::unique_ptr<transport::Node> here_ = network_.MakeNode("here");
  std::unique_ptr<transport::Node> there_ = network_.MakeNode("there");
  std::unique_ptr<ControllerPresence> presence_;
  std::vector<std::unique_ptr<transport::Publisher<msg::EmergencyStop>>> publishers_;
};

// A panel with a toggle switch publishes the stop, and later that it is over. The robot stays
// stopped; but a controller that was restarted took its word, and the robot went up.
TEST_F(Releases, OfAPanelDoNotCount) {
  Publish(*there_, true);
  Publish(*there_, false);
  EXPECT_EQ(seen_, Seen{"engaged"});
}

TEST_F(Releases, OfAnotherControllerCountAlsoWhereItsHeartbeatComesLater) {
  Publish(*there_, false);
  EXPECT_EQ(seen_, Seen{});
  const auto theirs = Presence(*there_, [](const Event&) {});
  theirs->Announce(1);
  network_.RunFor(seconds(2));
  EXPECT_EQ(seen_, Seen{"released"});
  Publish(*there_, false);
  EXPECT_EQ(seen_, (Seen{"released", "released"}));
}

// Two machines in one namespace and domain: this one, and another with a controller of its own.
class OtherMachines : public ::testing::Test {
 protected:
  using Rival = ControllerPresence::Rival;

  // What this machine's controller makes of the heartbeats of another controller with a higher
  // epoch.
  void Meet(const std::string& name, const std::string& id) {
    theirs_config_.name = name;
    theirs_ = ControllerPresence::Make(*there_, theirs_config_, {1, 7, "boot-b/1", "cat", id},
                                       [](const Event&) {})
                  .value();
    theirs_->Announce(9);
    network_.RunFor(seconds(2));
  }
  std::vector<std::string> Present() const {
    std::vector<std::string> names;
    for (const Rival& other : ours_->OtherMachines()) names.push_back(MachineText(other.machine));
    return names;
  }

  transport::sim::Network network_{1};
  MachineConfig config_ = MachineOf(2);
  MachineConfig theirs_config_ = MachineOf(2);
  std::unique_ptr<transport::Node> here_ = network_.MakeNode("here");
  std::unique_ptr<transport::Node> there_ = network_.MakeNode("there");
  using Names = std::vector<std::string>;
  Names recorded_;
  std::vector<Names> shown_;  // at each report
  std::vector<Event> events_;
  std::unique_ptr<ControllerPresence> theirs_;
  std::unique_ptr<ControllerPresence> ours_ = [this] {
    config_.name = "dog";
    auto ours = ControllerPresence::Make(
                    *here_, config_, {1, 1, "boot-a/1", "dog", "uuid-a"},
                    [this](const Event& event) { events_.push_back(event); },
                    [this](const Rival* other) {
                      if (other != nullptr) recorded_.push_back(MachineText(other->machine));
                      shown_.push_back(Present());
                    })
                    .value();
    ours->Announce(1);
    return ours;
  }();
};

TEST_F(OtherMachines, NeverFenceThisOneAndAreReportedOnce) {
  Meet("cat", "uuid-b");
  EXPECT_TRUE(events_.empty());
  EXPECT_FALSE(ours_->rival());
  network_.RunFor(std::chrono::minutes(9));
  EXPECT_EQ(recorded_, Names{"cat (id uuid-b)"});
  EXPECT_EQ(shown_, std::vector<Names>{{"cat (id uuid-b)"}});
}

TEST_F(OtherMachines, AreReportedAgainWhileTheyStay) {
  Meet("cat", "uuid-b");
  network_.RunFor(std::chrono::minutes(11));
  EXPECT_EQ(recorded_.size(), 2U);
}

TEST_F(OtherMachines, AreNotPresentAnyMoreWithoutHeartbeats) {
  Meet("cat", "uuid-b");
  theirs_ = nullptr;
  network_.RunFor(seconds(6));
  EXPECT_EQ(shown_, (std::vector<Names>{{"cat (id uuid-b)"}, {}}));
}

// It was not shown: it had been reported within the last 10 min.
TEST_F(OtherMachines, ThatComeBackAreShownAgainWithoutASecondRecord) {
  Meet("cat", "uuid-b");
  theirs_ = nullptr;
  network_.RunFor(seconds(6));
  Meet("cat", "uuid-b");
  EXPECT_EQ(shown_, (std::vector<Names>{{"cat (id uuid-b)"}, {}, {"cat (id uuid-b)"}}));
  EXPECT_EQ(recorded_, Names{"cat (id uuid-b)"});
}

TEST_F(OtherMachines, OfTheSameNameAreKnownByTheirId) {
  Meet("dog", "uuid-b");
  EXPECT_TRUE(events_.empty());
}

TEST_F(OtherMachines, OfAnOlderVersionAreKnownByTheirName) {
  Meet("cat", "");
  EXPECT_TRUE(events_.empty());
  Meet("dog", "");
  EXPECT_FALSE(events_.empty()) << "it may be another controller of this machine";
}

TEST_F(OtherMachines, AreNoneOfTheControllersOfOneMachine) {
  Meet("dog", "uuid-a");
  ASSERT_FALSE(events_.empty());
  EXPECT_EQ(std::get<event::RivalSeen>(events_.front()).epoch, Epoch(9));
  EXPECT_TRUE(recorded_.empty());
}

// What one of another host stores is on another disk.
TEST(ControllerPresence, DistinguishesARivalOfAnotherHostFromOneOfItsOwn) {
  for (const std::string& host : {std::string("here"), std::string("there")}) {
    transport::sim::Network network{1};
    const MachineConfig config = MachineOf(2);
    const auto first = network.MakeNode("first");
    const auto second = network.MakeNode("second");
    std::vector<event::RivalSeen> seen;
    const auto ours = ControllerPresence::Make(*first, config, {1, 1, "here"}, [&](const Event& e) {
                        if (const auto* rival = std::get_if<event::RivalSeen>(&e)) {
                          seen.push_back(*rival);
                        }
                      }).value();
    const auto theirs =
        ControllerPresence::Make(*second, config, {2, 2, host}, [](const Event&) {}).value();
    ours->Announce(1);
    theirs->Announce(2);
    network.RunFor(seconds(2));
    ASSERT_FALSE(seen.empty());
    EXPECT_EQ(seen.back().elsewhere, host == "there");
  }
}

// One that takes over on another host has not got the disk.
TEST(ControllerPresence, SaysThatAReleasedStopWaitsForARequest) {
  transport::sim::Network network{1};
  const MachineConfig config = MachineOf(2);
  const auto here = network.MakeNode("here");
  const auto there = network.MakeNode("there");
  const auto leads =
      ControllerPresence::Make(*here, config, {1, 1, "here"}, [](const Event&) {}).value();
  const auto starts =
      ControllerPresence::Make(*there, config, {2, 2, "there"}, [](const Event&) {}).value();
  leads->Announce(1);
  for (const bool awaits : {false, true, false}) {
    leads->SetAwaitsRequest(awaits);
    network.RunFor(seconds(2));
    ASSERT_TRUE(starts->rival());
    EXPECT_EQ(starts->rival()->awaits_request, awaits);
  }
  leads->SetAwaitsRequest(true);
  network.RunFor(Milliseconds(20));
  EXPECT_TRUE(starts->rival()->awaits_request) << "at once, not with the next heartbeat";
}

}  // namespace musher::testing::controller_presence_test
