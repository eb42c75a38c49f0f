// A whole machine in virtual time with one actuator of each protocol: "a" is Musher's own, "b" a
// CyberDog module, "c" a ROS 2 managed node.

#include <gmock/gmock.h>

#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/protocols/cyberdog_manager.hpp"
#include "musher/test/protocols/cyberdog_module.hpp"
#include "musher/test/protocols/ros_managed_node.hpp"

namespace musher::testing::mixed_robot_test {

using simulation::Act;
using simulation::SimRobot;

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class AMixedRobot : public ::testing::Test {
 protected:
  explicit AMixedRobot(bool critical = false) : robot_(1, Config(critical)) {
    robot_.UseProgram("b", [this](transport::Node& node) {
      auto module = std::make_shared<CyberdogModule>(node, "", "b", "b");
      module->script = module_script_;
      module_ = module.get();
      return module;
    });
    robot_.UseProgram("c", [this](transport::Node& node) {
      auto ros = std::make_shared<RosManagedNode>(node, "c");
      ros->script = node_script_;
      ros_ = ros.get();
      return ros;
    });
  }

  static MachineConfig Config(bool critical) {
    MachineConfig config = MachineOf(3);
    for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
    config.actuators[1].protocol = Protocol::kCyberdog;
    config.actuators[1].heartbeat_name = "b";
    config.actuators[1].critical = critical;
    config.actuators[2].protocol = Protocol::kRos2Lifecycle;
    return config;
  }

  void BringUp() {
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
    ASSERT_EQ(robot_.machine().state, "Active");
    ASSERT_THAT(robot_.Degraded(), IsEmpty());
    robot_.RunFor(std::chrono::seconds(1));  // the first beats
  }
  SwitchResult Set(const State& target) { return robot_.Set(target).value_or(SwitchResult{}); }
  void ExpectAllIn(const State& state) {
    EXPECT_EQ(robot_.machine().state, state);
    for (const ActuatorRecord& record : robot_.machine().actuators) {
      EXPECT_EQ(record.state(), state);
      EXPECT_EQ(record.presence, Presence::kPresent);
    }
    EXPECT_THAT(robot_.Degraded(), IsEmpty());
  }

  struct Robot : SimRobot {
    using SimRobot::SimRobot;
    std::vector<std::string> Degraded() const { return musher::Degraded(config(), machine()); }
  };

  std::map<std::string, CyberdogModule::Callback> module_script_;
  std::map<std::string, RosManagedNode::Callback> node_script_;
  CyberdogModule* module_ = nullptr;
  RosManagedNode* ros_ = nullptr;
  Robot robot_;
};

TEST_F(AMixedRobot, ComesUpSwitchesAndIsTornDown) {
  BringUp();
  ExpectAllIn("Active");
  for (const ActuatorRecord& record : robot_.machine().actuators) {
    EXPECT_EQ(record.report.pid, record.process);
  }
  EXPECT_TRUE(Set("LowPower").done());
  ExpectAllIn("LowPower");
  EXPECT_TRUE(Set("Active").done());
  EXPECT_THAT(module_->log(), ElementsAre("SelfCheck", "Active", "LowPower", "Active"));
  EXPECT_THAT(ros_->log(), ElementsAre("configure", "activate", "deactivate", "activate"));
  EXPECT_TRUE(Set("TearDown").done());
  EXPECT_EQ(robot_.machine().phase, Phase::kStopped);
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(robot_.IsAlive(name)) << name;
}

TEST_F(AMixedRobot, IsBroughtBackAsOneWhenOneCannotGoUp) {
  BringUp();
  ASSERT_TRUE(Set("LowPower").done());
  ros_->script["activate"].outcome = RosManagedNode::Outcome::kError;
  const SwitchResult result = Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_THAT(result.actuators[2].message, HasSubstr("activate failed"));
  ExpectAllIn("LowPower");
  EXPECT_EQ(ros_->state(), Ros2State::kInactive) << "configured again after its error";
  EXPECT_EQ(module_->log().back(), "LowPower");
}

TEST_F(AMixedRobot, FollowsWhenANodeIsOverdueOnTheWayDownOnceItIsFree) {
  BringUp();
  ros_->script["deactivate"].takes = Milliseconds(700);
  const SwitchResult result = Set("LowPower");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(result.actuators[2].outcome, ActuatorOutcome::kOverdue);
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("LowPower");
}

TEST_F(AMixedRobot, BringsANodeBackThatWasOverdueOnTheWayUp) {
  BringUp();
  ASSERT_TRUE(Set("LowPower").done());
  ros_->script["activate"].takes = Milliseconds(700);
  EXPECT_FALSE(Set("Active").done());
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("LowPower");
  EXPECT_EQ(ros_->state(), Ros2State::kInactive) << "its late success was taken back";
}

TEST_F(AMixedRobot, BringsAModuleBackThatWasOverdueOnTheWayUp) {
  BringUp();
  ASSERT_TRUE(Set("LowPower").done());
  module_->script["Active"].takes = Milliseconds(700);
  EXPECT_FALSE(Set("Active").done());
  EXPECT_THAT(robot_.Degraded(), ElementsAre("b"));
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("LowPower");
  EXPECT_THAT(module_->log(), ElementsAre("SelfCheck", "Active", "LowPower", "Active", "LowPower"));
}

TEST_F(AMixedRobot, ANodesLostReplyIsNoFailure) {
  BringUp();
  ros_->lost_change_replies = 1;
  EXPECT_TRUE(Set("LowPower").done());
}

TEST_F(AMixedRobot, AModulesLostReplyLeavesItUnknownAndSwitchesGoOnWithoutIt) {
  BringUp();
  module_->lost_replies = 1;
  EXPECT_EQ(Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  robot_.RunFor(std::chrono::minutes(1));
  EXPECT_THAT(robot_.Degraded(), ElementsAre("b"));
  for (const char* target : {"Active", "OTA"}) {
    const Time begun = robot_.network().now();
    const SwitchResult result = Set(target);
    EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded) << result.reason;
    EXPECT_LT(robot_.network().now() - begun, Milliseconds(50)) << "nobody waits for it";
    EXPECT_EQ(robot_.machine().actuators[2].state(), target);
  }
  EXPECT_THAT(module_->log(), ElementsAre("SelfCheck", "Active", "LowPower"))
      << "nothing more is sent until it answers";
  robot_.CrashActuator("b");
  robot_.StartActuator("b");
  robot_.RunFor(std::chrono::seconds(1));
  ExpectAllIn("OTA");
}

class AMixedRobotWithACriticalModule : public AMixedRobot {
 protected:
  AMixedRobotWithACriticalModule() : AMixedRobot(true) {}
};

TEST_F(AMixedRobotWithACriticalModule, GoesNoFurtherUpWhileItIsUnknown) {
  BringUp();
  module_->lost_replies = 1;
  Set("LowPower");
  const SwitchResult result = Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(result.reason, "critical b has not answered LowPower and cannot be queried");
}

TEST_F(AMixedRobot, NoticesTheEndOfAProcessAtOnceAndDrivesTheNextOne) {
  BringUp();
  for (const char* name : {"b", "c"}) {
    robot_.CrashActuator(name);
    const std::size_t i = *robot_.config().IndexOf(name);
    ASSERT_TRUE(
        robot_.RunUntil([&] { return robot_.machine().actuators[i].presence == Presence::kLost; },
                        Milliseconds(100)));
    if (!robot_.IsAlive(name)) robot_.StartActuator(name);
    robot_.RunFor(std::chrono::seconds(20));  // past the lease of the dead process
    ExpectAllIn("Active");
  }
}

TEST_F(AMixedRobot, AModuleThatBeatsNoMoreIsLostUntilItBeatsAgain) {
  BringUp();
  module_->beats = false;
  ASSERT_TRUE(
      robot_.RunUntil([&] { return robot_.machine().actuators[1].presence == Presence::kLost; },
                      Milliseconds(3000)));
  EXPECT_THAT(robot_.Degraded(), ElementsAre("b"));
  module_->beats = true;
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("Active");
}

TEST_F(AMixedRobot, ANodeThatCannotBeConfiguredIsDegradedAndTheRestComesUp) {
  node_script_["configure"].outcome = RosManagedNode::Outcome::kFailure;
  robot_.StartController();
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
  EXPECT_THAT(robot_.Degraded(), ElementsAre("c"));
  EXPECT_THAT(robot_.journal(), Contains(HasSubstr("configure failed")));
  ros_->script["configure"].outcome = RosManagedNode::Outcome::kSuccess;
  ros_->Change("configure");  // a person has repaired it
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("Active");
}

TEST_F(AMixedRobot, IsAdoptedByTheNextControllerWithoutBeingDisturbed) {
  BringUp();
  ASSERT_TRUE(Set("LowPower").done());
  const auto log = ros_->log();
  robot_.CrashController();
  robot_.RunFor(std::chrono::seconds(1));
  robot_.StartController();
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("LowPower");
  EXPECT_EQ(ros_->log(), log);
}

TEST_F(AMixedRobot, ATornDownNodeAndAModuleThatDoNotEndAreEnded) {
  BringUp();
  ros_->script["cleanup"].outcome = RosManagedNode::Outcome::kFailure;
  const SwitchResult result = Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(robot_.machine().phase, Phase::kStopped);
  for (const char* name : {"b", "c"}) EXPECT_FALSE(robot_.IsAlive(name)) << name;
}

// The other way round: our actuators under CyberDog's manager.
class UnderACyberdogManager : public ::testing::Test {
 protected:
  UnderACyberdogManager()
      : robot_(1, MachineOf(2), [this](const std::string& actuator, const State& state) {
          const auto act = acts_.find(actuator + ":" + state);
          return act == acts_.end() ? Act{} : act->second;
        }) {
    node_ = robot_.network().MakeNode("manager");
    manager_ = std::make_unique<CyberdogManager>(*node_, "", std::vector<std::string>{"a", "b"},
                                                 Milliseconds(100));
    robot_.StartActuator("a");
    robot_.StartActuator("b");
  }

  std::vector<CyberdogManager::Result> Set(const std::string& state) {
    std::optional<std::vector<CyberdogManager::Result>> results;
    manager_->SetState(state, [&](auto r) { results = std::move(r); });
    EXPECT_TRUE(robot_.RunUntil([&] { return results.has_value(); }));
    return *results;
  }

  std::map<std::string, Act> acts_;
  SimRobot robot_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<CyberdogManager> manager_;
};

TEST_F(UnderACyberdogManager, ActuatorsAreVisibleOnceTheyAreSetUpAndSwitch) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  for (const auto& result : Set("SelfCheck")) EXPECT_EQ(result.code, 0);
  for (const auto& result : Set("Active")) {
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.current_state, 4) << "ours is filled";
  }
  EXPECT_EQ(robot_.ReportOf("b")->state, "Active");
}

TEST_F(UnderACyberdogManager, AFailureIsItsCodeAndAnUnknownStateANakedEight) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  acts_["a:Active"].error = {5001, "no"};
  EXPECT_EQ(Set("Active").back().code, 5001);
  EXPECT_EQ(Set("Dance").back().code, 8);
}

TEST_F(UnderACyberdogManager, AnActuatorThatIsBusySaysSo) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  acts_["a:Active"].takes = Milliseconds(500);
  EXPECT_EQ(Set("Active").back().code, -1) << "the manager's own timeout";
  EXPECT_EQ(Set("LowPower").back().code, kCodeTargetBusy);
}

TEST_F(UnderACyberdogManager, ActuatorsBeatWhileSomebodyListens) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  robot_.RunFor(std::chrono::seconds(10));
  for (const char* name : {"a", "b"}) {
    EXPECT_GE(manager_->heard[name], 19) << name;
    EXPECT_LE(manager_->heard[name], 20) << name;
  }
}

TEST_F(UnderACyberdogManager, ActuatorsThatAControllerHoldsAreDenied) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  robot_.StartController();
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
  EXPECT_EQ(Set("LowPower").back().code, kCodePermissionDenied);
  EXPECT_EQ(robot_.ReportOf("a")->state, "Active");
}

}  // namespace musher::testing::mixed_robot_test
