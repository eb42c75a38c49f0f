#include "musher/lifecycle/config/ros2_states.hpp"

#include <gmock/gmock.h>

#include <vector>

namespace musher::ros2_states_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using S = Ros2State;

// The names of the transitions from one primary state to another.
std::vector<std::string_view> PathBetween(S from, S goal) {
  std::vector<std::string_view> names;
  while (const auto step = NextTransition(from, goal)) {
    EXPECT_EQ(step->from, from);
    names.push_back(step->name);
    from = step->to;
  }
  return names;
}

TEST(Ros2States, ActiveIsReachedByWayOfInactive) {
  EXPECT_THAT(PathBetween(S::kUnconfigured, S::kActive), ElementsAre("configure", "activate"));
  EXPECT_THAT(PathBetween(S::kInactive, S::kActive), ElementsAre("activate"));
  EXPECT_THAT(PathBetween(S::kActive, S::kActive), IsEmpty());
}

TEST(Ros2States, FinalizedIsReachedByCleanupAndShutdown) {
  EXPECT_THAT(PathBetween(S::kActive, S::kFinalized),
              ElementsAre("deactivate", "cleanup", "shutdown"));
  EXPECT_THAT(PathBetween(S::kUnconfigured, S::kFinalized), ElementsAre("shutdown"));
}

TEST(Ros2States, UnconfiguredIsReachedFromAboveOnly) {
  EXPECT_THAT(PathBetween(S::kActive, S::kUnconfigured), ElementsAre("deactivate", "cleanup"));
}

TEST(Ros2States, FinalizedAndTransitionStatesHaveNoTransition) {
  for (const S goal : {S::kUnconfigured, S::kInactive, S::kActive}) {
    EXPECT_THAT(PathBetween(S::kFinalized, goal), IsEmpty());
    EXPECT_THAT(PathBetween(S::kActivating, goal), IsEmpty());
    EXPECT_THAT(PathBetween(S::kUnknown, goal), IsEmpty());
  }
}

TEST(Ros2States, AStateOfTheMachineHasADefaultGoalUnlessTheConfigGivesAnother) {
  const std::map<State, S> configured = {{"LowPower", S::kUnconfigured}};
  EXPECT_EQ(Ros2GoalOf(configured, "SetUp"), S::kInactive);
  EXPECT_EQ(Ros2GoalOf(configured, "Active"), S::kActive);
  EXPECT_EQ(Ros2GoalOf(configured, "TearDown"), S::kFinalized);
  EXPECT_EQ(Ros2GoalOf(configured, "LowPower"), S::kUnconfigured);
  for (const char* state : {"DeActive", "Protected", "OTA", "Error", "Parked"}) {
    EXPECT_EQ(Ros2GoalOf(configured, state), S::kInactive) << state;
  }
}

}  // namespace musher::ros2_states_test
