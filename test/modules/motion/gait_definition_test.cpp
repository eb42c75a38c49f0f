// The definition of a gait: its two texts, and which answers of the board count.

#include "musher/modules/motion/gait_definition.hpp"

#include <gmock/gmock.h>

#include "musher/test/modules/motion/harness.hpp"

namespace musher::motion::testing::gait_definition_test {

using ::testing::HasSubstr;

class Definition : public ::testing::Test {
 protected:
  std::int32_t CodeOf(const GaitDefinition::Output& output) {
    if (!output.ended) return -1;
    return *output.ended ? kCodeOk : output.ended->error().code;
  }
  void After(Duration time) { now_ += time; }

  const UserGait gait_{"sections", "steps", 300, {}};
  GaitDefinition definition_;
  Time now_{std::chrono::hours(1)};
};

TEST_F(Definition, SendsTheStepsOnceTheSectionsAreAccepted) {
  EXPECT_EQ(definition_.Begin(gait_, now_).text, "sections");
  EXPECT_EQ(definition_.OnAnswer(true, now_).text, "steps");
  EXPECT_EQ(CodeOf(definition_.OnAnswer(true, now_)), 0);
  EXPECT_EQ(definition_.NextDeadline(), std::nullopt);
}

TEST_F(Definition, EndsWhereATextIsRefused) {
  definition_.Begin(gait_, now_);
  definition_.OnAnswer(true, now_);
  const auto refused = definition_.OnAnswer(false, now_);
  ASSERT_EQ(CodeOf(refused), 3031);
  EXPECT_THAT(refused.ended->error().message, HasSubstr("refuses the steps"));
  EXPECT_EQ(definition_.Begin(gait_, now_).text, "sections");
}

TEST_F(Definition, EndsWithoutAnAnswerWithin1s) {
  definition_.Begin(gait_, now_);
  EXPECT_EQ(definition_.NextDeadline(), now_ + kGaitAnswer);
  After(Milliseconds(900));
  EXPECT_FALSE(definition_.OnTime(now_).ended);
  After(Milliseconds(100));
  EXPECT_EQ(CodeOf(definition_.OnTime(now_)), 3035);
}

// Otherwise the board would get steps whose sections it has not accepted.
TEST_F(Definition, TakesNoLateAnswerForThatToTheNextGait) {
  definition_.Begin(gait_, now_);
  After(kGaitAnswer);
  definition_.OnTime(now_);
  After(Milliseconds(100));
  const auto early = definition_.Begin(gait_, now_);
  ASSERT_EQ(CodeOf(early), 3011);
  EXPECT_FALSE(early.text) << "its answer and the late one look the same";
  EXPECT_THAT(early.ended->error().message, HasSubstr("try again in 4900 ms"));
  EXPECT_FALSE(definition_.OnAnswer(true, now_).text) << "the late one";
  EXPECT_EQ(definition_.Begin(gait_, now_).text, "sections");
}

TEST_F(Definition, BeginsAgain5sAfterALostAnswer) {
  definition_.Begin(gait_, now_);
  After(kGaitAnswer);
  definition_.OnTime(now_);
  After(kLateGaitAnswer);
  EXPECT_EQ(definition_.Begin(gait_, now_).text, "sections");
  EXPECT_EQ(definition_.OnAnswer(true, now_).text, "steps");
  EXPECT_EQ(CodeOf(definition_.OnAnswer(true, now_)), 0);
}

TEST_F(Definition, FailsWhenAnotherProgramDefinesAGait) {
  definition_.Begin(gait_, now_);
  const auto ended = definition_.OnOtherText("192.168.44.1:5000", now_);
  ASSERT_EQ(CodeOf(ended), 3011);
  EXPECT_THAT(ended.ended->error().message, HasSubstr("192.168.44.1:5000"));
  EXPECT_FALSE(definition_.OnAnswer(true, now_).text);
  EXPECT_EQ(CodeOf(definition_.Begin(gait_, now_)), 3011) << "one of two answers is missing";
  definition_.OnAnswer(true, now_);
  EXPECT_EQ(definition_.Begin(gait_, now_).text, "sections");
}

TEST_F(Definition, TakesNoAnswerToAnotherProgramForItsOwn) {
  definition_.OnOtherText("192.168.44.1:5000", now_);
  EXPECT_EQ(CodeOf(definition_.Begin(gait_, now_)), 3011);
  definition_.OnAnswer(false, now_);
  EXPECT_EQ(definition_.Begin(gait_, now_).text, "sections");
}

TEST(OtherGait, EndsTheMotionThatWouldExecuteIt) {
  Harness harness;
  const RequestToken show = harness.RequestMotion(400);
  harness.RunFor(Milliseconds(200));
  harness.Do(motion_event::OtherGait{"another program has given the motion board a gait"});
  EXPECT_EQ(harness.CodeOf(show), 3031);
  EXPECT_EQ(harness.Commanded().back(), kRecoveryStand);
  const RequestToken stand = harness.RequestMotion(kRecoveryStand);
  harness.Do(motion_event::OtherGait{"another program has given the motion board a gait"});
  EXPECT_EQ(harness.CodeOf(stand), kCodeOk) << "it has no gait of a user";
}

}  // namespace musher::motion::testing::gait_definition_test
