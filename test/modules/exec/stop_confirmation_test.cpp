#include "musher/modules/exec/stop_confirmation.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace musher::exec::stop_confirmation_test {

constexpr const char* kNotEnded = "[emergency_stop] has not ended: `brake`";
constexpr const char* kFailed = "[emergency_stop]: exit code 9 of `brake`";
constexpr const char* kLowPowerRuns =
    "its callback for LowPower still runs and may switch on again";

class AStop : public ::testing::Test {
 protected:
  // The action runs once, to its end.
  void Act() { stop_.EndAction(stop_.BeginAction(), ""); }
  void BeginBeforeAStop() { stop_.BeginCommand("LowPower", StopAtBegin::kNone); }
  void BeginBelowAStop() { stop_.BeginCommand("LowPower", StopAtBegin::kBefore); }
  bool EndCommand() { return stop_.EndCommand(false); }

  StopConfirmation stop_{kNotEnded};
};

TEST_F(AStop, IsConfirmedOnceItsActionHasSucceeded) {
  const std::uint64_t number = stop_.BeginAction();
  EXPECT_EQ(stop_.Trouble(), kNotEnded);
  stop_.EndAction(number, "");
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, IsNotConfirmedByAnActionThatFails) {
  stop_.EndAction(stop_.BeginAction(), kFailed);
  EXPECT_EQ(stop_.Trouble(), kFailed);
  Act();
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, IsConfirmedByTheActionOfTheLastStop) {
  const std::uint64_t first = stop_.BeginAction();
  const std::uint64_t second = stop_.BeginAction();
  stop_.EndAction(first, "");
  EXPECT_EQ(stop_.Trouble(), kNotEnded);
  stop_.EndAction(second, "");
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, IsNotConfirmedWhileACommandRunsThatBeganBeforeIt) {
  BeginBeforeAStop();
  Act();
  EXPECT_EQ(stop_.Trouble(), kLowPowerRuns);
  EXPECT_FALSE(EndCommand()) << "the core repeats the action";
  EXPECT_EQ(stop_.Trouble(), kNotEnded);
  Act();
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, IsNotConfirmedWhileACommandRunsBelowIt) {
  Act();
  BeginBelowAStop();
  EXPECT_EQ(stop_.Trouble(), kLowPowerRuns);
  EXPECT_TRUE(EndCommand());
  Act();
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, IsNotConfirmedWhileACommandRunsBelowTheOneBefore) {
  Act();
  BeginBelowAStop();
  Act();
  EXPECT_EQ(stop_.Trouble(), kLowPowerRuns);
  EXPECT_FALSE(EndCommand()) << "the core repeats the action, which ran twice";
  EXPECT_EQ(stop_.Trouble(), kNotEnded);
  Act();
  EXPECT_EQ(stop_.Trouble(), "");
}

// It came after the core had begun the callback, and before its command began: musher-exec and the
// core both repeated the action.
TEST_F(AStop, RepeatsItsActionOnceAfterACommandThatWasToBeginWhenItCame) {
  Act();
  stop_.BeginCommand("Active", StopAtBegin::kSince);
  EXPECT_EQ(stop_.Trouble(), "its callback for Active still runs and may switch on again");
  EXPECT_FALSE(EndCommand()) << "the core repeats the action, which ran twice";
  EXPECT_EQ(stop_.Trouble(), kNotEnded);
  Act();
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, LeavesNothingToRepeatToTheCommandsAfterTheOneThatWasToBegin) {
  Act();
  stop_.BeginCommand("Active", StopAtBegin::kSince);
  EXPECT_FALSE(EndCommand());
  Act();
  BeginBelowAStop();
  EXPECT_TRUE(EndCommand());
  Act();
  BeginBeforeAStop();
  EXPECT_FALSE(EndCommand());
  EXPECT_EQ(stop_.Trouble(), "");
}

// The command may have switched on again what this action has switched off.
TEST_F(AStop, IsNotConfirmedByAnActionThatBeganBesideACommandAndEndsAfterIt) {
  BeginBeforeAStop();
  const std::uint64_t beside = stop_.BeginAction();
  EXPECT_FALSE(EndCommand());
  stop_.EndAction(beside, "");
  EXPECT_EQ(stop_.Trouble(), kNotEnded);
  Act();
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, IsNotConfirmedByAnActionThatBeganBeforeACommandAndEndsAfterIt) {
  const std::uint64_t before = stop_.BeginAction();
  BeginBelowAStop();
  EXPECT_TRUE(EndCommand());
  const std::uint64_t repeated = stop_.BeginAction();
  stop_.EndAction(before, "");
  EXPECT_EQ(stop_.Trouble(), kNotEnded);
  stop_.EndAction(repeated, "");
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, NamesWhatItsActionCouldNotDoAlsoWhileACommandRuns) {
  BeginBeforeAStop();
  stop_.EndAction(stop_.BeginAction(), kFailed);
  EXPECT_EQ(stop_.Trouble(), kFailed);
}

TEST_F(AStop, NeedsNoActionAfterACommandThatLeavesNothing) {
  Act();
  stop_.BeginCommand("TearDown", StopAtBegin::kBefore);
  EXPECT_FALSE(stop_.EndCommand(true));
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST_F(AStop, ThatComesAfterACommandIsConfirmedByOneAction) {
  BeginBelowAStop();
  EXPECT_TRUE(EndCommand());
  Act();
  BeginBeforeAStop();
  EXPECT_FALSE(EndCommand());
  EXPECT_EQ(stop_.Trouble(), "");
  Act();
  EXPECT_EQ(stop_.Trouble(), "");
}

// Its action ends while the next command runs, which began after the release.
TEST_F(AStop, ThatIsReleasedLeavesNoTroubleBehind) {
  const std::uint64_t number = stop_.BeginAction();
  BeginBeforeAStop();
  stop_.EndAction(number, "");
  EXPECT_FALSE(EndCommand());
  EXPECT_EQ(stop_.Trouble(), "");
}

TEST(AStopWithNothingToStop, IsConfirmedAtOnceUnlessACommandRuns) {
  StopConfirmation stop("");
  stop.BeginAction();
  EXPECT_EQ(stop.Trouble(), "");
  stop.BeginCommand("LowPower", StopAtBegin::kNone);
  stop.BeginAction();
  EXPECT_EQ(stop.Trouble(), kLowPowerRuns);
  EXPECT_FALSE(stop.EndCommand(false));
  EXPECT_EQ(stop.Trouble(), "");
}

}  // namespace musher::exec::stop_confirmation_test
