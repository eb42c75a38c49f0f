// What a standby receives, and what it goes on with: the last status of the controller that is
// gone.

#include "musher/controller/standby.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>

#include "musher/lifecycle/policy/policy.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::standby_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class GoingOn : public ::testing::Test {
 protected:
  GoingOn() {
    for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run"};
    for (const ActuatorConfig& actuator : config_.actuators) {
      msg::ActuatorInfo info;
      info.name = actuator.name;
      info.state = "Active";
      info.presence = "present";
      info.health = "well";
      status_.actuators.push_back(info);
    }
  }

  msg::ActuatorInfo& Of(const std::string& name) {
    return *std::ranges::find(status_.actuators, name, &msg::ActuatorInfo::name);
  }
  std::vector<StoredActuator> Stored() const { return StoredActuatorsOf(config_, status_); }

  MachineConfig config_ = MachineOf(3);
  msg::MachineStatus status_;
};

TEST_F(GoingOn, WithARobotOfWhichAllIsUpKeepsNothingDown) {
  EXPECT_THAT(Stored(), IsEmpty());
}

TEST_F(GoingOn, LeavesDownWhatWasTornDownAloneOrHasEnded) {
  Of("a").state = "TearDown";
  Of("a").presence = "lost";
  Of("b").presence = "lost";
  const auto stored = Stored();
  ASSERT_THAT(stored, SizeIs(2));
  EXPECT_EQ(stored[0], (StoredActuator{"a", StaysDown::kTornDown, {}, {}}));
  EXPECT_EQ(stored[1], (StoredActuator{"b", StaysDown::kGivenUp, State("Active"), {}}));
}

TEST_F(GoingOn, KeepsWhatAPersonHolds) {
  Of("c").state = "LowPower";
  Of("c").held = true;
  EXPECT_EQ(Stored().at(0), (StoredActuator{"c", StaysDown::kNo, {}, State("LowPower")}));
}

// The host of the controller is gone with its actuators, and may come back.
TEST_F(GoingOn, LeavesNothingDownThatWasOutOfReachOrBeingRestarted) {
  Of("a").presence = "lost";
  Of("a").health = "partitioned";
  Of("b").presence = "lost";
  Of("b").restarting = true;
  EXPECT_THAT(Stored(), IsEmpty());
}

TEST_F(GoingOn, KnowsNoStateWhereTheActuatorWasNotThere) {
  Of("a").presence = "absent";
  EXPECT_EQ(Stored().at(0), (StoredActuator{"a", StaysDown::kGivenUp, {}, {}}));
}

TEST_F(GoingOn, IgnoresAnActuatorThatIsNotInTheConfig) {
  Of("a").name = "unknown";
  status_.actuators[0].state = "TearDown";
  EXPECT_THAT(Stored(), IsEmpty());
}

// It is down until a person starts it by hand: then it is not torn down.
TEST_F(GoingOn, DoesNotHoldDownWhatIsStartedByHand) {
  config_.actuators[*config_.IndexOf("a")].command.clear();
  Of("a").presence = "absent";
  EXPECT_EQ(Stored().at(0).stays_down, StaysDown::kNo);
}

// The battery of the robot, by the last status and by what the host of the standby has stored.
class GoingOnWithABattery : public GoingOn {
 protected:
  GoingOnWithABattery() {
    config_.policy.emplace().battery.emplace();
    status_.policy.active = true;
  }

  void Limit(BatteryLevel level) {
    status_.policy.ceiling = CeilingState(config_, level);
    status_.policy.ceiling_reason = "the battery is low";
  }
  BatteryLevel LevelAfter(BatteryLevel own) const {
    StoredPolicy stored;
    stored.level = own;
    return StoredPolicyOf(config_, status_, stored).level;
  }
};

TEST_F(GoingOnWithABattery, IsLimitedAsTheControllerBeforeIt) {
  status_.policy.battery = 12;
  Limit(BatteryLevel::kProtected);
  EXPECT_EQ(LevelAfter(BatteryLevel::kFree), BatteryLevel::kProtected);
  Limit(BatteryLevel::kLowPower);
  EXPECT_EQ(LevelAfter(BatteryLevel::kFree), BatteryLevel::kLowPower);
  Limit(BatteryLevel::kEmpty);  // whether it is still empty, the next sample says
  EXPECT_EQ(LevelAfter(BatteryLevel::kFree), BatteryLevel::kLowPower);
}

// What this host has stored may be of a day on which it has led.
TEST_F(GoingOnWithABattery, IsNotLimitedByAnOldFileWhereTheControllerBeforeItKnewBetter) {
  status_.policy.battery = 80;
  EXPECT_EQ(LevelAfter(BatteryLevel::kLowPower), BatteryLevel::kFree);
}

TEST_F(GoingOnWithABattery, IsNeverRaisedWhereTheControllerBeforeItKnewNoBattery) {
  status_.policy.battery = -1;
  EXPECT_EQ(LevelAfter(BatteryLevel::kLowPower), BatteryLevel::kLowPower);
  Limit(BatteryLevel::kLowPower);
  EXPECT_EQ(LevelAfter(BatteryLevel::kProtected), BatteryLevel::kLowPower);
  status_.policy = {};
  EXPECT_EQ(LevelAfter(BatteryLevel::kProtected), BatteryLevel::kProtected);
}

// It was accepted on the day on which this host has led, and would switch the robot off now.
TEST_F(GoingOnWithABattery, DoesNotGoOnWithAnOldPowerOff) {
  StoredPolicy stored;
  stored.power = PowerAhead::kOff;
  EXPECT_EQ(StoredPolicyOf(config_, status_, stored).power, PowerAhead::kNone);
}

// A controller and an actuator on two hosts, as a standby on a third one receives them.
class Listening : public ::testing::Test {
 protected:
  static constexpr const char* kId = "id-1";

  Listening() {
    config_.name = "dog";
    config_.failover = Milliseconds(3000);
    standby_ = musher::Standby::Make(*desk_, config_, [this] { return identity_; }).value();
    ActuatorConfig& legs = config_.actuators[0];
    msg::ActuatorStatus status;
    status.name = legs.name;
    status.machine = "dog";
    status.machine_id = kId;
    status.participant = legs_->participant().value();
    EXPECT_TRUE(statuses_->Publish(status));
  }

  void PublishMachine(const std::string& phase, const std::string& id = kId) {
    msg::MachineStatus status;
    status.machine = "dog";
    status.machine_id = id;
    status.phase = phase;
    status.epoch = 7;
    status.participant = brain_->participant().value();
    ASSERT_TRUE(machines_->Publish(status));
    network_.RunFor(Milliseconds(50));
  }
  // With heartbeats of both, as far as they are there; returns why the standby does not lead.
  std::string For(Duration time, bool controller, bool actuator) {
    return While(time, [&] {
      EXPECT_TRUE(!controller || controllers_->Publish(Heartbeat()));
      EXPECT_TRUE(!actuator || heartbeats_->Publish(HeartbeatOfLegs(!controller)));
    });
  }
  // The controller is gone, and the bridge sends that heartbeat of a controller.
  std::string Beside(const msg::ControllerHeartbeat& heartbeat) {
    const auto controllers =
        transport::MakePublisher<msg::ControllerHeartbeat>(
            *bridge_, transport::ControllerHeartbeatTopic(""), transport::kLatchedQos)
            .value();
    return While(Milliseconds(5000), [&] {
      EXPECT_TRUE(controllers->Publish(heartbeat));
      EXPECT_TRUE(heartbeats_->Publish(HeartbeatOfLegs(true)));
    });
  }
  msg::ControllerHeartbeat Heartbeat() const {
    msg::ControllerHeartbeat heartbeat;
    heartbeat.machine = "dog";
    heartbeat.machine_id = kId;
    heartbeat.epoch = 7;
    heartbeat.participant = brain_->participant().value();
    return heartbeat;
  }
  msg::ActuatorHeartbeat HeartbeatOfLegs(bool controller_lost) const {
    msg::ActuatorHeartbeat heartbeat;
    heartbeat.name = config_.actuators[0].name;
    heartbeat.controller_lost = controller_lost;
    return heartbeat;
  }
  // What the bridge has published as long as it lives.
  template <class Message>
  std::unique_ptr<transport::Publisher<Message>> FromBridge(const std::string& topic,
                                                            const Message& message) {
    auto publisher =
        transport::MakePublisher<Message>(*bridge_, topic, transport::kLatchedQos).value();
    EXPECT_TRUE(publisher->Publish(message));
    network_.RunFor(Milliseconds(500));
    return publisher;
  }
  std::string While(Duration time, const std::function<void()>& publish) {
    std::string why;
    for (Duration passed{}; passed < time; passed += Milliseconds(100)) {
      publish();
      network_.RunFor(Milliseconds(100));
      why = standby_->WhyNot();
      if (why.empty()) return why;
    }
    return why;
  }

  MachineConfig config_ = MachineOf(1);
  MachineIdentity identity_{"dog", kId};
  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::unique_ptr<transport::Node> brain_ = network_.MakeNode("brain");
  std::unique_ptr<transport::Node> legs_ = network_.MakeNode("legs");
  std::unique_ptr<transport::Node> bridge_ = network_.MakeNode("bridge");
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> controllers_ =
      transport::MakePublisher<msg::ControllerHeartbeat>(
          *brain_, transport::ControllerHeartbeatTopic(""), transport::kLatchedQos)
          .value();
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> machines_ =
      transport::MakePublisher<msg::MachineStatus>(*brain_, transport::MachineStatusTopic(""),
                                                   transport::kLatchedQos)
          .value();
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> statuses_ =
      transport::MakePublisher<msg::ActuatorStatus>(*legs_, transport::ActuatorStatusTopic(""),
                                                    transport::kLatchedQos)
          .value();
  std::unique_ptr<transport::Publisher<msg::ActuatorHeartbeat>> heartbeats_ =
      transport::MakePublisher<msg::ActuatorHeartbeat>(
          *legs_, transport::ActuatorHeartbeatTopic(""), transport::kHeartbeatQos)
          .value();
  std::unique_ptr<musher::Standby> standby_;
};

TEST_F(Listening, LeadsOnceTheControllerIsGoneAndKnowsItsLastStatus) {
  PublishMachine("running");
  EXPECT_THAT(For(Milliseconds(2000), true, true), HasSubstr("a controller leads"));
  EXPECT_THAT(For(Milliseconds(5000), false, true), IsEmpty());
  EXPECT_EQ(standby_->last_status()->epoch, 7U);
}

TEST_F(Listening, LeadsNothingThatHasHadNoController) {
  EXPECT_THAT(For(Milliseconds(10'000), false, true), HasSubstr("was received yet"));
}

// A person tears the robot down, and starts a module by hand: it would be taken over.
TEST_F(Listening, LeadsNothingOfARobotThatWasTornDown) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  PublishMachine("stopped");
  EXPECT_THAT(For(Milliseconds(10'000), false, true), HasSubstr("was received yet"));
}

// Its folder is new: until an actuator of its host shows the id, only the name is known.
TEST_F(Listening, LeadsNothingByTheStatusOfAnotherRobotOfTheName) {
  identity_.id.clear();
  PublishMachine("running", "id-2");
  For(Milliseconds(2000), true, true);
  identity_.id = kId;
  EXPECT_THAT(For(Milliseconds(10'000), false, true), HasSubstr("was received yet"));
  PublishMachine("running");
  EXPECT_THAT(For(Milliseconds(2000), true, true), HasSubstr("a controller leads"));
  EXPECT_THAT(For(Milliseconds(5000), false, true), IsEmpty());
}

TEST_F(Listening, LeadsNothingWhereNoActuatorSaysThatItHasLostItsController) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  EXPECT_THAT(For(Milliseconds(10'000), false, false), HasSubstr("only 0 of 1"));
}

TEST_F(Listening, LeadsNothingThatIsLedOutOfItsReach) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  const auto led = [this] { EXPECT_TRUE(heartbeats_->Publish(HeartbeatOfLegs(false))); };
  EXPECT_THAT(While(Milliseconds(10'000), led), HasSubstr("only 0 of 1"));
}

TEST_F(Listening, LeadsNothingOfWhichItHasReceivedTheStatusAlone) {
  PublishMachine("running");
  EXPECT_THAT(For(Milliseconds(10'000), false, true), HasSubstr("was received yet"));
}

TEST_F(Listening, LeadsNothingThatWasTornDownAndWhoseNextControllerIsGoneBeforeItsFirstStatus) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  PublishMachine("stopped");
  EXPECT_FALSE(standby_->last_status());
  For(Milliseconds(1000), true, true);
  EXPECT_THAT(For(Milliseconds(10'000), false, true), HasSubstr("was received yet"));
}

TEST_F(Listening, LeadsNothingThatWasTornDownWhereOnlyAStatusComesAfterThat) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  PublishMachine("stopped");
  PublishMachine("running");
  EXPECT_THAT(For(Milliseconds(10'000), false, true), HasSubstr("was received yet"));
}

TEST_F(Listening, LeadsNothingWhoseIdNoActuatorOfItsHostHasShown) {
  identity_.id.clear();
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  EXPECT_THAT(For(Milliseconds(10'000), false, true), HasSubstr("has shown the id"));
}

// A bridge between two networks, or another robot in range: nothing of it counts.
TEST_F(Listening, LeadsBesideHeartbeatsOfItsControllerThatAreRepeated) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  EXPECT_THAT(Beside(Heartbeat()), IsEmpty());
}

TEST_F(Listening, LeadsBesideTheControllerOfAnotherRobot) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  msg::ControllerHeartbeat other = Heartbeat();
  other.machine = "cat";
  other.machine_id = "id-2";
  other.participant = bridge_->participant().value();
  EXPECT_THAT(Beside(other), IsEmpty());
}

TEST_F(Listening, LeadsAfterAStoppedStatusOfItsControllerThatIsRepeated) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  msg::MachineStatus stopped;
  stopped.machine = "dog";
  stopped.machine_id = kId;
  stopped.phase = "stopped";
  stopped.participant = brain_->participant().value();
  const auto latched = FromBridge(transport::MachineStatusTopic(""), stopped);
  EXPECT_THAT(For(Milliseconds(5000), false, true), IsEmpty());
}

TEST_F(Listening, KeepsTheLastStatusOfItsMachineBesideThatOfAnotherRobot) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  msg::MachineStatus other;
  other.machine = "cat";
  other.machine_id = "id-2";
  other.phase = "running";
  other.participant = bridge_->participant().value();
  const auto latched = FromBridge(transport::MachineStatusTopic(""), other);
  EXPECT_EQ(standby_->last_status()->machine, "dog");
  EXPECT_THAT(For(Milliseconds(5000), false, true), IsEmpty());
}

TEST_F(Listening, KnowsTheProcessOfAnActuatorBesideARepeatedStatusAndOneOfAnotherRobot) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  msg::ActuatorStatus status;
  status.name = config_.actuators[0].name;
  status.machine = "dog";
  status.machine_id = kId;
  status.participant = legs_->participant().value();
  const auto repeated = FromBridge(transport::ActuatorStatusTopic(""), status);
  status.machine_id = "id-2";
  status.participant = bridge_->participant().value();
  const auto of_other = FromBridge(transport::ActuatorStatusTopic(""), status);
  EXPECT_THAT(For(Milliseconds(5000), false, true), IsEmpty());
}

TEST_F(Listening, LeadsNothingByTheHeartbeatsOfAnotherProcess) {
  PublishMachine("running");
  For(Milliseconds(2000), true, true);
  const auto heartbeats =
      transport::MakePublisher<msg::ActuatorHeartbeat>(
          *bridge_, transport::ActuatorHeartbeatTopic(""), transport::kHeartbeatQos)
          .value();
  const auto lost = [&] { EXPECT_TRUE(heartbeats->Publish(HeartbeatOfLegs(true))); };
  EXPECT_THAT(While(Milliseconds(10'000), lost), HasSubstr("only 0 of 1"));
}

// A standby and a command of its host.
class Reporting : public ::testing::Test {
 protected:
  std::optional<StandbyReport> Call() {
    const auto call = StandbyCall::Make(loop_, name_);
    if (!call) return std::nullopt;
    loop_.RunUntil([&] { return call->ended(); }, loop_.Now() + std::chrono::minutes(2));
    EXPECT_TRUE(call->ended());
    return call->Report();
  }

  transport::LinuxEventLoop loop_;
  std::string name_ = StandbyName(0, "standby_test_" + std::to_string(getpid()));
};

TEST_F(Reporting, AnswersACommandOfThisHostWithWhyItDoesNotLead) {
  const StandbyReport report{{"dog", "id-1"}, "a controller leads,\nor has led", 0};
  const auto server = StandbyServer::Make(loop_, name_, [&] { return report; });
  ASSERT_TRUE(server) << server.error().message;
  StandbyReport expected = report;
  expected.pid = getpid();
  EXPECT_EQ(Call(), expected);
}

TEST_F(Reporting, AnswersNothingOnceItLeads) {
  auto server = StandbyServer::Make(loop_, name_, [] { return StandbyReport{}; });
  ASSERT_TRUE(server) << server.error().message;
  server.value() = nullptr;
  EXPECT_EQ(Call(), std::nullopt);
}

// Its process is suspended.
TEST_F(Reporting, IsKnownAlsoWhereItDoesNotAnswer) {
  transport::LinuxEventLoop frozen;
  const auto server = StandbyServer::Make(frozen, name_, [] { return StandbyReport{}; });
  ASSERT_TRUE(server) << server.error().message;
  const auto call = StandbyCall::Make(loop_, name_);
  ASSERT_TRUE(call);
  EXPECT_EQ(call->Report(), (StandbyReport{{}, "it does not answer", getpid()}));
}

}  // namespace musher::testing::standby_test
