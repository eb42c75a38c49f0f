// TearDown is the last state of an actuator: a second command for it is done.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/one_actuator.hpp"

namespace musher::actuator_tear_down_test {

using namespace actuator_action;  // NOLINT(google-build-using-namespace)
using actuator_event::CallbackEnded;
using actuator_event::EmergencyStopReceived;
using ::testing::_;
using testing::Actions;
using ::testing::Contains;
using ::testing::Each;
using ::testing::Field;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::VariantWith;

class TearDown : public testing::OneActuator {};

// The machine is torn down while the actuator is in the TearDown of its own restart.
TEST_F(TearDown, ATearDownThatWaitsForAnotherOneIsDoneWithIt) {
  SetUpIt();
  Do(Command(1, "TearDown"));
  Do(Command(2, "TearDown"));
  const Actions ended = Do(CallbackEnded{});
  EXPECT_THAT(ended, Not(Contains(VariantWith<RunCallback>(_))));
  EXPECT_THAT(AnswersIn(ended), Each(Field(&Answer::verdict, Verdict::kDone)));
  EXPECT_THAT(AnswersIn(ended), SizeIs(2));
  EXPECT_EQ(core_.report.outcome_number, CommandNumber(2));
  EXPECT_EQ(core_.report.outcome_code, kCodeOk);
}

TEST_F(TearDown, ATearDownOfAnActuatorThatIsTornDownIsDone) {
  SetUpIt();
  Switch(1, "TearDown");
  const Actions actions = Do(Command(2, "TearDown"));
  EXPECT_EQ(AnswerIn(actions).verdict, Verdict::kDone);
  EXPECT_THAT(actions, Not(Contains(VariantWith<RunCallback>(_))));
  EXPECT_EQ(AnswerIn(Do(Command(3, "Active"))).code, kCodeStateInvalid);
}

TEST_F(TearDown, NorDoesItRunAgainAfterAnEmergencyStop) {
  SetUpIt();
  Switch(1, "Active");
  Do(EmergencyStopReceived{4, true, SenderOf(1)});
  Switch(2, "TearDown");
  ASSERT_TRUE(core_.report.held_by_stop);
  const Actions actions = Do(Command(3, "TearDown"));
  EXPECT_EQ(AnswerIn(actions).verdict, Verdict::kDone);
  EXPECT_THAT(actions, Not(Contains(VariantWith<RunCallback>(_))));
}

// What it did by itself before is not the outcome of the command.
TEST_F(TearDown, ATearDownThatWaitsForOneOfTheActuatorItselfIsDone) {
  config_.actuators[0].on_controller_lost = "TearDown";
  config_.actuators[0].controller_lost = Milliseconds(100);
  SetUpIt();
  Switch(1, "Active");
  Do(Command(2, "LowPower"));
  Do(CallbackEnded{5001, "joint 7 is hot"});
  now_ += std::chrono::seconds(1);
  ASSERT_THAT(Do(actuator_event::TimePassed{}),
              Contains(VariantWith<RunCallback>(RunCallback{"TearDown"})));
  Do(Command(3, "TearDown"));
  EXPECT_THAT(AnswersIn(Do(CallbackEnded{})), Each(Field(&Answer::verdict, Verdict::kDone)));
  EXPECT_EQ(core_.report.outcome_number, CommandNumber(3));
  EXPECT_EQ(core_.report.outcome_code, kCodeOk);
  EXPECT_FALSE(core_.report.detached);
}

TEST_F(TearDown, AnotherCommandThatWaitsForATearDownIsRefused) {
  SetUpIt();
  Do(Command(1, "TearDown"));
  Do(Command(2, "LowPower"));
  const std::vector<Answer> answers = AnswersIn(Do(CallbackEnded{}));
  ASSERT_THAT(answers, SizeIs(2));
  EXPECT_EQ(answers[0].verdict, Verdict::kDone);
  EXPECT_EQ(answers[1].verdict, Verdict::kRefused);
  EXPECT_EQ(core_.report.outcome_number, CommandNumber(1));
}

}  // namespace musher::actuator_tear_down_test
