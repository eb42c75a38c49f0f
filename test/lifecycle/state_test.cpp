#include "musher/lifecycle/state.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <type_traits>

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

TEST(ACallback, RaisesNothingOnTheWayDownAndOnceMoreAtDeActiveOrBelow) {
  const auto raises_nothing = [](std::string_view from, std::string_view to) {
    return RaisesNothing(BuiltInRank(from), *BuiltInRank(to));
  };
  EXPECT_TRUE(raises_nothing("Active", "Protected"));
  EXPECT_FALSE(raises_nothing("Protected", "Protected"));
  EXPECT_FALSE(raises_nothing("LowPower", "Protected"));
  EXPECT_TRUE(raises_nothing("DeActive", "DeActive"));
  EXPECT_TRUE(raises_nothing("LowPower", "LowPower"));
  EXPECT_FALSE(raises_nothing("LowPower", "DeActive"));
  EXPECT_FALSE(raises_nothing("Error", "LowPower"));
  EXPECT_TRUE(raises_nothing("SetUp", "DeActive")) << "a step of a start";
  EXPECT_FALSE(raises_nothing("SetUp", "Protected"));
}

static_assert(!std::is_convertible_v<std::string, State> &&
                  !std::is_convertible_v<std::string_view, State>,
              "the name of an actuator, or a message's field, is no state by itself");
static_assert(std::is_constructible_v<State, std::string> &&
              std::is_convertible_v<BuiltInState, State>);

bool SetState(const std::string& actuator, const State& state) {
  return actuator == "arm" && state == kActive;
}
template <typename... Arguments>
constexpr bool kTakesActuatorAndState = std::is_invocable_v<decltype(&SetState), Arguments...>;
static_assert(kTakesActuatorAndState<std::string, State> &&
                  !kTakesActuatorAndState<State, std::string>,
              "swapped arguments do not compile");

TEST(AState, IsReadAsAText) {
  const State state = "Active";
  const std::string text = state;
  EXPECT_TRUE(SetState("arm", state));
  EXPECT_EQ(text, "Active");
  EXPECT_EQ("to " + state + " now", "to Active now");
  EXPECT_EQ(state, kActive);
  EXPECT_EQ(state, State(text));
  EXPECT_NE(state, State());
  EXPECT_TRUE(State().empty());
}

TEST(AState, FromOutsideIsShortened) {
  EXPECT_EQ(State(std::string(70, 'x')).Shortened(), State(std::string(64, 'x')));
}

}  // namespace musher::state_test
