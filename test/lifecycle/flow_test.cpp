#include "musher/lifecycle/config/flow.hpp"

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::flow_test {

using ::testing::ElementsAre;

TEST(Flow, NoSwitchLeadsToAStepOfAProcessStart) {
  const MachineConfig config = MachineOf(1);
  EXPECT_FALSE(FlowAllows(config, "Active", "SetUp"));
  EXPECT_FALSE(FlowAllows(config, "SetUp", "SetUp"));
  EXPECT_FALSE(FlowAllows(config, "Active", "Uninitialized"));
}

TEST(Flow, NoSwitchLeadsToUninitializedWithAnyConfig) {
  MachineConfig config = MachineOf(1);
  config.states.emplace_back(kUninitialized);
  config.flow.push_back({"Active", State(kUninitialized)});
  EXPECT_FALSE(FlowAllows(config, "Active", "Uninitialized"));
  EXPECT_FALSE(FlowAllows(config, "Uninitialized", "Uninitialized"));
}

TEST(Flow, FromTearDownNothingLeadsBack) {
  const MachineConfig config = MachineOf(1);
  for (const State& state : config.states) EXPECT_FALSE(FlowAllows(config, "TearDown", state));
}

TEST(Flow, ACheckLeadsOnAndAnyStateIntoIt) {
  MachineConfig config = MachineOf(1);
  config.flow = {{"Active", "LowPower"}};
  EXPECT_THAT(Reachable(config, "SelfCheck"),
              ElementsAre("TearDown", "Active", "DeActive", "Error"));
  EXPECT_TRUE(FlowAllows(config, "LowPower", "SelfCheck"));
  EXPECT_FALSE(FlowAllows(config, "Uninitialized", "SelfCheck"));
}

TEST(Flow, IsThatOfTheConfigBesideWhatHoldsForAll) {
  MachineConfig config = MachineOf(1);
  config.flow = {{"Active", "LowPower"}};
  EXPECT_THAT(Reachable(config, "Active"), ElementsAre("TearDown", "SelfCheck", "LowPower"));
  EXPECT_THAT(Reachable(config, "LowPower"), ElementsAre("TearDown", "SelfCheck"));
  EXPECT_TRUE(FlowAllows(config, "LowPower", "LowPower"));
}

TEST(Flow, RisesIsToAHigherRankAndFromAStepOfAStartAboveDeActive) {
  const MachineConfig config = MachineOf(1);
  EXPECT_TRUE(Rises(config, "LowPower", "DeActive"));
  EXPECT_FALSE(Rises(config, "DeActive", "DeActive"));
  EXPECT_FALSE(Rises(config, "SetUp", "DeActive"));
  EXPECT_TRUE(Rises(config, "SetUp", "Protected"));
  EXPECT_FALSE(Rises(config, "Active", "SelfCheck"));
}

TEST(Flow, FallsIsToALowerRankAndNeverFromOrToAStepOfAStart) {
  const MachineConfig config = MachineOf(1);
  EXPECT_TRUE(Falls(config, "Active", "Protected"));
  EXPECT_FALSE(Falls(config, "Active", "Active"));
  EXPECT_FALSE(Falls(config, "LowPower", "Active"));
  EXPECT_FALSE(Falls(config, "SetUp", "Error"));
  EXPECT_FALSE(Falls(config, "Active", "SelfCheck"));
}

}  // namespace musher::testing::flow_test
