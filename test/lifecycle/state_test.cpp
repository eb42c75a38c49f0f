#include "musher/lifecycle/state.hpp"

#include <gtest/gtest.h>

namespace musher::state_test {

TEST(BuiltInStates, HaveCyberDogsNumbers) {
  EXPECT_EQ(MachineStateNumber("Uninitialized"), 0);
  EXPECT_EQ(MachineStateNumber("SetUp"), 1);
  EXPECT_EQ(MachineStateNumber("TearDown"), 2);
  EXPECT_EQ(MachineStateNumber("SelfCheck"), 3);
  EXPECT_EQ(MachineStateNumber("Active"), 4);
  EXPECT_EQ(MachineStateNumber("DeActive"), 5);
  EXPECT_EQ(MachineStateNumber("Protected"), 6);
  EXPECT_EQ(MachineStateNumber("LowPower"), 7);
  EXPECT_EQ(MachineStateNumber("OTA"), 8);
  EXPECT_EQ(MachineStateNumber("Error"), 9);
}

TEST(BuiltInStates, GiveEveryOtherStateTheNumberTen) {
  EXPECT_EQ(MachineStateNumber("Parked"), 10);
  EXPECT_EQ(MachineStateNumber(""), 10);
}

TEST(BuiltInStates, AreKnownByTheirExactNameOnly) {
  EXPECT_TRUE(IsBuiltInState("DeActive"));
  EXPECT_FALSE(IsBuiltInState("Deactive"));
  EXPECT_EQ(BuiltInStates().size(), 10U);
}

TEST(BuiltInRank, RisesFromTearDownToActive) {
  int expected = 0;
  for (const auto* state :
       {"TearDown", "Error", "OTA", "LowPower", "DeActive", "Protected", "Active"}) {
    EXPECT_EQ(BuiltInRank(state), expected++) << state;
  }
}

TEST(BuiltInRank, IsMissingForTheStepsOfAStartAndForUnknownStates) {
  for (const auto* state : {"Uninitialized", "SetUp", "SelfCheck", "Parked"}) {
    EXPECT_FALSE(BuiltInRank(state)) << state;
  }
}

}  // namespace musher::state_test
