#include "musher/lifecycle/ros2/managed_node.hpp"

#include <gmock/gmock.h>

#include <map>

#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::managed_node_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using S = Ros2State;

constexpr std::uint8_t kConfigure = 1;
constexpr std::uint8_t kCleanup = 2;
constexpr std::uint8_t kActivate = 3;
constexpr std::uint8_t kDeactivate = 4;
constexpr std::uint8_t kShutdown = 5;

ManagedNode In(const State& state, const State& target = "") {
  ManagedNode node;
  node.Observe(state, target);
  return node;
}

TEST(AManagedNode, IsInTheStateThatFollowsFromItsMusherState) {
  const std::map<State, S> expected = {{"Uninitialized", S::kUnconfigured},
                                       {"SetUp", S::kUnconfigured},
                                       {"SelfCheck", S::kInactive},
                                       {"DeActive", S::kInactive},
                                       {"Protected", S::kInactive},
                                       {"LowPower", S::kInactive},
                                       {"OTA", S::kInactive},
                                       {"Active", S::kActive},
                                       {"Error", S::kUnconfigured},
                                       {"TearDown", S::kFinalized}};
  for (const auto& [own, state] : expected) EXPECT_EQ(In(own).state(), state) << own;
}

TEST(AManagedNode, IsInATransitionStateWhileACallbackRuns) {
  EXPECT_EQ(In("SetUp", "SelfCheck").state(), S::kConfiguring);
  EXPECT_EQ(In("SelfCheck", "Active").state(), S::kActivating);
  EXPECT_EQ(In("Active", "DeActive").state(), S::kDeactivating);
  EXPECT_EQ(In("Active", "TearDown").state(), S::kShuttingDown);
  EXPECT_EQ(In("Active", "Error").state(), S::kErrorProcessing);
  EXPECT_EQ(In("DeActive", "LowPower").state(), S::kInactive) << "the ROS 2 state does not change";
  EXPECT_EQ(In("Active", "SelfCheck").state(), S::kActive) << "a check in the run phase";
  EXPECT_EQ(In("Uninitialized", "SetUp").state(), S::kUnconfigured);
}

// The transitions that nav2's manager requests, in its order.
TEST(AManagedNode, ExecutesAllTransitionsOfANav2Node) {
  ManagedNode node = In("SetUp");
  const auto go = [&](std::uint8_t id, const State& own) {
    const auto begun = node.Begin(id, "");
    ASSERT_TRUE(begun) << begun.error().message;
    EXPECT_EQ(node.state(), begun.value().by);
    node.Observe(own, "");
    node.End(true);
    EXPECT_EQ(node.state(), begun.value().to);
  };
  go(kConfigure, "SelfCheck");
  go(kActivate, "Active");
  go(kDeactivate, "DeActive");
  go(kActivate, "Active");
  go(kDeactivate, "DeActive");
  go(kCleanup, "DeActive");
  go(kConfigure, "DeActive");
  go(kCleanup, "DeActive");
  go(kShutdown, "TearDown");
}

TEST(AManagedNode, AcceptsATransitionByItsLabelIndependentOfTheId) {
  ManagedNode node = In("SetUp");
  const auto begun = node.Begin(0, "configure");
  ASSERT_TRUE(begun);
  EXPECT_EQ(begun.value().id, kConfigure);
  node.End(false);
  const auto shutdown = node.Begin(0, "shutdown");
  ASSERT_TRUE(shutdown);
  EXPECT_EQ(shutdown.value().id, kShutdown) << "the shutdown of the current state";
}

TEST(AManagedNode, RefusesTransitionsThatItsStateDoesNotHaveWithAReason) {
  ManagedNode node = In("SetUp");
  EXPECT_THAT(node.Begin(kActivate, "").error().message, HasSubstr("the node is unconfigured"));
  EXPECT_EQ(node.Begin(kActivate, "").error().code, kCodeStateInvalid);
  EXPECT_THAT(node.Begin(0, "fly").error().message, HasSubstr("there is no transition 'fly'"));
  EXPECT_THAT(node.Begin(10, "").error().message, HasSubstr("there is no transition '10'"));
  ASSERT_TRUE(node.Begin(kConfigure, ""));
  EXPECT_THAT(node.Begin(kConfigure, "").error().message, HasSubstr("the node is configuring"));
  EXPECT_EQ(node.state(), S::kConfiguring);
}

TEST(AManagedNode, KeepsItsStateAfterAFailedTransition) {
  ManagedNode node = In("DeActive");
  ASSERT_TRUE(node.Begin(kCleanup, ""));
  node.End(true);
  ASSERT_TRUE(node.Begin(kConfigure, ""));
  node.Observe("DeActive", "SelfCheck");
  node.Observe("DeActive", "");
  node.End(false);
  EXPECT_EQ(node.state(), S::kUnconfigured) << "its cleanup still counts";
}

TEST(AManagedNode, ForgetsAManagersCleanupWhenAnotherCommandChangesItsState) {
  ManagedNode node = In("DeActive");
  ASSERT_TRUE(node.Begin(kCleanup, ""));
  node.End(true);
  node.Observe("DeActive", "");
  EXPECT_EQ(node.state(), S::kUnconfigured);
  node.Observe("DeActive", "LowPower");
  node.Observe("LowPower", "");
  EXPECT_EQ(node.state(), S::kInactive);
}

TEST(AManagedNode, ForgetsAManagersCleanupWhenItsStateChangesDuringAFailedTransition) {
  ManagedNode node = In("DeActive");
  ASSERT_TRUE(node.Begin(kCleanup, ""));
  node.End(true);
  ASSERT_TRUE(node.Begin(kConfigure, ""));
  node.Observe("LowPower", "");
  node.End(false);
  EXPECT_EQ(node.state(), S::kInactive);
}

TEST(TheGraphOfAManagedNode, IsThatOfRos2) {
  EXPECT_THAT(Ros2Graph(), SizeIs(25));
  EXPECT_THAT(Ros2States(), SizeIs(11));
  const auto labels = [](S state) {
    std::vector<std::string> all;
    for (const Ros2Edge& edge : RequestableIn(state)) {
      all.push_back(std::to_string(edge.id) + " " + std::string(edge.label));
    }
    return all;
  };
  EXPECT_THAT(labels(S::kUnconfigured), ElementsAre("1 configure", "5 shutdown"));
  EXPECT_THAT(labels(S::kInactive), ElementsAre("2 cleanup", "3 activate", "6 shutdown"));
  EXPECT_THAT(labels(S::kActive), ElementsAre("4 deactivate", "7 shutdown"));
  EXPECT_THAT(labels(S::kFinalized), IsEmpty());
  EXPECT_THAT(labels(S::kActivating), IsEmpty()) << "the ends of transitions cannot be requested";
}

// The state that a transition of an actuator of the config stands for.
State TargetIn(const MachineConfig& config, S state, const std::string& label) {
  ManagedNode node;
  node.Observe(state == S::kUnconfigured ? kSetUp : state == S::kActive ? kActive : kDeActive, "");
  const auto transition = node.Begin(0, label);
  if (!transition) return "no transition";
  return TargetOf(transition.value(), config.actuators[0], config).value_or("no state");
}

TEST(ATransitionOfAnActuator, StandsForOneOfItsStates) {
  const MachineConfig config = testing::MachineOf(1);
  EXPECT_EQ(TargetIn(config, S::kUnconfigured, "configure"), "SelfCheck");
  EXPECT_EQ(TargetIn(config, S::kInactive, "activate"), "Active");
  EXPECT_EQ(TargetIn(config, S::kActive, "deactivate"), "DeActive");
  EXPECT_EQ(TargetIn(config, S::kInactive, "cleanup"), "DeActive") << "its process keeps running";
  EXPECT_EQ(TargetIn(config, S::kActive, "shutdown"), "TearDown");
}

TEST(ATransitionOfAnActuator, StandsForTheNextBestStateIfAStateIsMissing) {
  MachineConfig config = testing::MachineOf(1);
  config.actuators[0].states = {"SetUp", "Active", "LowPower", "OTA", "Protected"};
  EXPECT_EQ(TargetIn(config, S::kUnconfigured, "configure"), "") << "no callback has to run";
  EXPECT_EQ(TargetIn(config, S::kActive, "deactivate"), "Protected");
  config.actuators[0].states = {"SetUp", "Active"};
  EXPECT_EQ(TargetIn(config, S::kActive, "deactivate"), "no state");
}

TEST(ATransitionOfTheMachine, SwitchesToTheStateInTheConfig) {
  MachineConfig config = testing::MachineOf(1);
  const auto target = [&](S state, const std::string& label) {
    ManagedNode node;
    node.Observe(state == S::kUnconfigured ? kSetUp
                 : state == S::kActive     ? kActive
                                           : kDeActive,
                 "");
    return TargetOf(node.Begin(0, label).value(), config).value_or("no state");
  };
  EXPECT_EQ(target(S::kUnconfigured, "configure"), "SelfCheck");
  EXPECT_EQ(target(S::kInactive, "activate"), "Active");
  EXPECT_EQ(target(S::kActive, "deactivate"), "DeActive");
  EXPECT_EQ(target(S::kInactive, "cleanup"), "TearDown");
  EXPECT_EQ(target(S::kUnconfigured, "shutdown"), "TearDown");
  config.ros2.deactivate = "LowPower";
  config.ros2.cleanup = "DeActive";
  EXPECT_EQ(target(S::kActive, "deactivate"), "LowPower");
  EXPECT_EQ(target(S::kInactive, "cleanup"), "DeActive");
}

TEST(ATransitionOfTheMachine, DeactivatesToTheHighestRestWhereItsStateIsMissing) {
  MachineConfig config = testing::MachineOf(1);
  std::erase(config.states, State("DeActive"));
  ManagedNode node = In("Active");
  EXPECT_EQ(TargetOf(node.Begin(kDeactivate, "").value(), config), "Protected");
}

TEST(TheLogOfRefusals, LogsTheFirstAtOnceAndThenOneLineInTenSeconds) {
  RefusalLog log;
  const Time begin{};
  EXPECT_EQ(log.Refused("no", begin), "no");
  for (int i = 1; i < 5000; ++i) {
    EXPECT_EQ(log.Refused("no", begin + Milliseconds(i)), std::nullopt);
  }
  EXPECT_EQ(log.Refused("no", begin + Milliseconds(10'000)),
            "no (and 4999 more since the last message)");
}

}  // namespace musher::managed_node_test
