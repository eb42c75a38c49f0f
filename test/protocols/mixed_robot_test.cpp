// Switches, start-up, faults and adoption of a machine with an actuator of each protocol.

#include "musher/test/protocols/mixed_robot.hpp"

#include "musher/test/lifecycle/coordination/records.hpp"

namespace musher::testing::mixed_robot_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(AMixedRobot, ComesUpSwitchesAndIsTornDown) {
  BringUp();
  ExpectAllIn("Active");
  for (const KnownActuator& known : robot_.machine().actuators) {
    EXPECT_EQ(known.report.pid, known.process.pid);
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

TEST_F(AMixedRobot, IsUndoneAsAWholeWhenAnActuatorCannotGoUp) {
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

TEST_F(AMixedRobot, AModulesLostReplyLeavesItUnknownAndSwitchesContinueWithoutIt) {
  BringUp();
  module_->lost_replies = 1;
  EXPECT_EQ(Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  robot_.RunFor(std::chrono::minutes(1));
  EXPECT_THAT(robot_.Degraded(), ElementsAre("b"));
  for (const BuiltInState target : {kActive, kOta}) {
    const Time begun = robot_.network().now();
    const SwitchResult result = Set(target);
    EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded) << result.reason;
    EXPECT_LT(robot_.network().now() - begun, Milliseconds(50))
        << "the switch does not wait for it";
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
    const ActuatorIndex i = *robot_.config().IndexOf(name);
    ASSERT_TRUE(
        robot_.RunUntil([&] { return robot_.machine().actuators[i].presence == Presence::kLost; },
                        Milliseconds(100)));
    if (!robot_.IsAlive(name)) robot_.StartActuator(name);
    robot_.RunFor(std::chrono::seconds(20));  // past the lease of the dead process
    ExpectAllIn("Active");
  }
}

TEST_F(AMixedRobot, AModuleWithoutHeartbeatsIsLostUntilTheyResume) {
  BringUp();
  module_->sends_heartbeats = false;
  ASSERT_TRUE(
      robot_.RunUntil([&] { return robot_.machine().actuators[1].presence == Presence::kLost; },
                      Milliseconds(3000)));
  EXPECT_THAT(robot_.Degraded(), ElementsAre("b"));
  module_->sends_heartbeats = true;
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("Active");
}

class AMixedRobotWhoseNodeCannotBeConfigured : public AMixedRobot {
 protected:
  static MachineConfig WithALongSetUp() {
    MachineConfig config = Config(false);
    ActuatorConfig& node = config.actuators[2];
    for (std::size_t i = 0; i < node.states.size(); ++i) {
      if (node.states[i] == kSetUp) node.times[i] = std::chrono::seconds(5);
    }
    return config;
  }
  AMixedRobotWhoseNodeCannotBeConfigured() : AMixedRobot(WithALongSetUp()) {}

  // Of the node, about its failure.
  static constexpr const char* kWords = "configure failed; the node is unconfigured now";

  void BringUpWithout() {
    node_script_["configure"].outcome = RosManagedNode::Outcome::kFailure;
    const Time begun = robot_.network().now();
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
    EXPECT_LT(robot_.network().now() - begun, std::chrono::seconds(1));
    EXPECT_EQ(robot_.machine().state, "Active");
    ASSERT_THAT(robot_.Degraded(), ElementsAre("c"));
    robot_.RunFor(std::chrono::seconds(2));
    EXPECT_THAT(Fault(), Is(texts::SetUpFailed(kCodeFailed, kWords)))
        << "no later reason replaces it";
    EXPECT_THAT(ros_->log(), ElementsAre("configure")) << "no automatic retry";
  }
  const std::optional<ActuatorFault>& Fault() const { return robot_.machine().actuators[2].fault; }
  void Repair() { ros_->script["configure"].outcome = RosManagedNode::Outcome::kSuccess; }
};

TEST_F(AMixedRobotWhoseNodeCannotBeConfigured, StartsWithoutItAtOnceAndReportsWhy) {
  ASSERT_NO_FATAL_FAILURE(BringUpWithout());
}

TEST_F(AMixedRobotWhoseNodeCannotBeConfigured, ConfiguresItByASelfCheck) {
  ASSERT_NO_FATAL_FAILURE(BringUpWithout());
  EXPECT_EQ(Set("SelfCheck").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(Fault(), Is(texts::Reported(ActuatorOutcome::kFailed, kWords)));
  Repair();
  EXPECT_TRUE(Set("SelfCheck").done());
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("Active");
}

TEST_F(AMixedRobotWhoseNodeCannotBeConfigured, ConfiguresItByASwitchToTheCurrentState) {
  ASSERT_NO_FATAL_FAILURE(BringUpWithout());
  EXPECT_EQ(Set("Active").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(Fault(), Is(texts::Reported(ActuatorOutcome::kFailed, kWords)));
  Repair();
  const SwitchResult result = Set("Active");
  EXPECT_TRUE(result.done()) << result.reason;
  ExpectAllIn("Active");
  EXPECT_THAT(ros_->log(), ElementsAre("configure", "configure", "configure", "activate"));
}

TEST_F(AMixedRobotWhoseNodeCannotBeConfigured, ConfiguresItByTheNextSwitchUp) {
  ASSERT_NO_FATAL_FAILURE(BringUpWithout());
  EXPECT_EQ(Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(ros_->log(), ElementsAre("configure")) << "not in a switch down";
  EXPECT_EQ(Set("Active").outcome, SwitchOutcome::kDoneDegraded)
      << "it does not delay the other actuators";
  Set("LowPower");
  Repair();
  EXPECT_TRUE(Set("Active").done());
  ExpectAllIn("Active");
}

TEST_F(AMixedRobotWhoseNodeCannotBeConfigured, DrivesItWhenAPersonHasConfiguredIt) {
  ASSERT_NO_FATAL_FAILURE(BringUpWithout());
  Repair();
  ros_->Change("configure");
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("Active");
}

TEST_F(AMixedRobot, DrivesANodeBackAfterATransitionByAnotherClient) {
  BringUp();
  ros_->Change("deactivate");
  robot_.RunFor(std::chrono::seconds(1));
  ExpectAllIn("Active");
  EXPECT_EQ(ros_->state(), Ros2State::kActive);
  EXPECT_THAT(robot_.journal(),
              Contains(texts::ActuatorDrifted("c", "DeActive", std::nullopt).message));
  ASSERT_TRUE(Set("LowPower").done());
  ros_->Change("activate");
  robot_.RunFor(std::chrono::seconds(1));
  ExpectAllIn("LowPower");
  EXPECT_EQ(ros_->state(), Ros2State::kInactive);
}

TEST_F(AMixedRobot, IsAdoptedByTheNextControllerWithoutBeingDisturbed) {
  BringUp();
  ASSERT_TRUE(Set("LowPower").done());
  const auto log = ros_->log();
  const std::vector<std::int32_t> pids = Pids();
  robot_.CrashController();
  robot_.RunFor(std::chrono::seconds(1));
  robot_.StartController();
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("LowPower");
  EXPECT_EQ(ros_->log(), log);
  EXPECT_EQ(Pids(), pids);
  EXPECT_TRUE(Set("TearDown").done());
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(robot_.IsAlive(name)) << name;
}

// The node is inactive in Protected and in DeActive; the Musher actuator determines the state.
TEST_F(AMixedRobot, IsAdoptedInTheStateOfItsMusherActuatorsThoughANodeMayBeLessActive) {
  BringUp();
  ASSERT_TRUE(Set("Protected").done());
  robot_.CrashController();
  robot_.StartController();
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("Protected");
}

TEST_F(AMixedRobot, FinishesItsStartWhenTheControllerCrashesDuringIt) {
  robot_.StartController();
  ASSERT_TRUE(robot_.RunUntil([&] { return ros_ && ros_->state() == Ros2State::kInactive; }));
  ASSERT_EQ(robot_.machine().phase, Phase::kStarting);
  robot_.CrashController();
  robot_.StartController();
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
  robot_.RunFor(std::chrono::seconds(2));
  ExpectAllIn("Active");
}

TEST_F(AMixedRobot, ATornDownNodeAndAModuleThatDoNotEndAreEnded) {
  BringUp();
  ros_->script["cleanup"].outcome = RosManagedNode::Outcome::kFailure;
  const SwitchResult result = Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(robot_.machine().phase, Phase::kStopped);
  for (const char* name : {"b", "c"}) EXPECT_FALSE(robot_.IsAlive(name)) << name;
}

}  // namespace musher::testing::mixed_robot_test
