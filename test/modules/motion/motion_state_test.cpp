// What the state of the machine does to motion: gating, emergency stop, lying down.

#include <gmock/gmock.h>

#include "musher/test/modules/motion/stage.hpp"

namespace musher::motion::testing::motion_state_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Error kInvalid{3003, "not in LowPower"};
const Error kProtected{3013, "the battery is low, charge it first"};

// --- Gating

TEST(MotionGate, RefusesAResultCommandWithTheCodeAndReasonOfItsCapability) {
  Stage stage;
  stage.refused["back_flip"] = kProtected;
  const auto token = stage.Ask(121);
  EXPECT_EQ(stage.CodeOf(token), 3013);
  EXPECT_EQ(stage.answers.at(token).message, kProtected.message);
  EXPECT_THAT(stage.log, Contains(HasSubstr("the battery is low")));
  EXPECT_THAT(stage.sent, IsEmpty());
  EXPECT_EQ(stage.CodeOf(stage.Ask(111)), kCodeOk) << "standing up is another capability";
}

TEST(MotionGate, RefusesAServoFrameWithOneResponse) {
  Stage stage;
  stage.refused["walk"] = kInvalid;
  stage.Servo(303);
  ASSERT_EQ(stage.told.size(), 1U);
  EXPECT_EQ(stage.told[0].code, 3003);
  EXPECT_FALSE(stage.told[0].result);
  stage.RunFor(Milliseconds(500));
  EXPECT_THAT(stage.sent, IsEmpty());
}

TEST(MotionGate, StopsTheBodyWhenTheStateForbidsFurtherFrames) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.refused["walk"] = kInvalid;
  const Time then = stage.now;
  stage.Stream(303, Milliseconds(500));
  EXPECT_THAT(stage.Commanded(), ElementsAre(303, kWalkStand));
  EXPECT_LE(stage.sent.back().at, then + Milliseconds(250));
}

TEST(MotionGate, IsAskedAgainWhenTheMotionBegins) {
  Stage stage;
  stage.Body(kGetDown);
  const auto token = stage.Ask(121);
  stage.RunFor(Milliseconds(200));
  stage.refused["back_flip"] = kProtected;  // while it stands up for it
  EXPECT_EQ(stage.CodeOf(token), 3013);
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand));
}

TEST(MotionGate, IsAskedAgainWhenAServoMotionBeginsAfterStandingUp) {
  Stage stage;
  stage.Body(kGetDown);
  stage.Servo(303);
  stage.refused["walk"] = kInvalid;
  for (int i = 0; i < 40; ++i) {
    stage.RunFor(Milliseconds(25));
    if (stage.core.servo) stage.core.servo->last_frame = stage.now;
  }
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand));
  EXPECT_FALSE(stage.core.servo);
}

TEST(MotionGate, IsShutBeforeTheFirstActive) {
  Stage stage;
  stage.core.closed = State(kUninitialized);
  EXPECT_EQ(stage.CodeOf(stage.Ask(111)), 3003);
  stage.Servo(303);
  EXPECT_EQ(stage.ServoCode(), 3003);
  EXPECT_THAT(stage.sent, IsEmpty());
}

// --- A state that leaves no room for motion

TEST(MotionState, ThatIsClosedStopsAWalkAtOnce) {
  for (const std::string_view state : {kDeActive, kError, kLowPower}) {
    Stage stage;
    stage.Stream(303, Milliseconds(500));
    stage.Do(motion_event::Closed{State(state)});
    EXPECT_EQ(stage.sent.back().command.id, kWalkStand);
    EXPECT_EQ(stage.sent.back().at, stage.now);
    stage.Servo(303);
    EXPECT_EQ(stage.ServoCode(), 3003);
  }
}

TEST(MotionState, ThatIsTearDownOrOtaSendsNoWalkStand) {
  for (const std::string_view state : {kTearDown, kOta}) {
    Stage stage;
    stage.Stream(303, Milliseconds(500));
    stage.Do(motion_event::Closed{State(state)});
    stage.RunFor(Milliseconds(500));
    EXPECT_THAT(stage.Commanded(), ElementsAre(303));
    EXPECT_TRUE(stage.core.Idle());
  }
}

TEST(MotionState, ThatIsErrorAnswersWhoWaitsWith3003AndBreaksOffADance) {
  Stage stage;
  stage.board.motion = Milliseconds(60'000);
  const auto dance = stage.Ask(140);
  stage.RunFor(Milliseconds(1000));
  stage.Do(motion_event::Closed{State(kError)});
  EXPECT_EQ(stage.CodeOf(dance), 3003);
  EXPECT_THAT(stage.Commanded(), ElementsAre(140, kRecoveryStand));
}

TEST(MotionState, ThatIsErrorLetsAFlipLand) {
  Stage stage;
  const auto flip = stage.Ask(121);
  stage.RunFor(Milliseconds(200));
  stage.Do(motion_event::Closed{State(kError)});
  EXPECT_EQ(stage.CodeOf(flip), 3003);
  stage.RunFor(Milliseconds(1000));
  EXPECT_THAT(stage.Commanded(), ElementsAre(121));
}

TEST(MotionState, ThatIsErrorEndsATimedWalkStanding) {
  Stage stage;
  MotionArguments arguments;
  arguments.duration_ms = 10'000;
  stage.board.motion = Milliseconds(10'000);
  stage.Ask(303, 0, arguments);
  stage.RunFor(Milliseconds(1000));
  stage.Do(motion_event::Closed{State(kError)});
  EXPECT_EQ(stage.sent.back().command.id, kWalkStand);
}

TEST(MotionState, ThatIsActiveAgainMovesNothingByItself) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.Do(motion_event::Closed{State(kLowPower)});
  stage.RunFor(Milliseconds(500));
  ASSERT_EQ(stage.CodeOf(stage.LieDown(kGetDown, 3)), kCodeOk);
  const std::size_t before = stage.sent.size();
  stage.Do(motion_event::Opened{});
  stage.RunFor(Milliseconds(5000));
  EXPECT_EQ(stage.sent.size(), before);
}

// --- Lying down

TEST(MotionLieDown, TakesTheBodyDownFromStanding) {
  Stage stage;
  EXPECT_EQ(stage.CodeOf(stage.LieDown(kGetDown, 3)), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(kGetDown));
}

TEST(MotionLieDown, DoesNothingWhereTheBodyLiesAlready) {
  for (const std::int32_t lying : {kEmergencyStop, kGetDown}) {
    Stage stage;
    stage.Body(lying);
    EXPECT_EQ(stage.CodeOf(stage.LieDown(kPassiveGetDown, 0)), kCodeOk);
    EXPECT_THAT(stage.sent, IsEmpty());
  }
}

TEST(MotionLieDown, IsNotHeldUpByTheStateOrByWhoHasTheBody) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.Do(motion_event::Closed{State(kOta)});
  stage.refused[""] = kInvalid;
  EXPECT_EQ(stage.CodeOf(stage.LieDown(kGetDown, 0)), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(303, kGetDown));
}

TEST(MotionLieDown, InterruptsAnything) {
  Stage stage;
  const auto flip = stage.Ask(121);
  stage.RunFor(Milliseconds(100));
  EXPECT_EQ(stage.CodeOf(stage.LieDown(kGetDown, 3)), kCodeOk);
  EXPECT_EQ(stage.CodeOf(flip), 3003);
}

// In the original the state callback reported success whether the body lay or not.
TEST(MotionLieDown, ThatFailsThreeTimesSaysSo) {
  Stage stage;
  stage.board.deaf = true;
  const Time begin = stage.now;
  EXPECT_EQ(stage.CodeOf(stage.LieDown(kGetDown, 3)), 3035);
  EXPECT_EQ(stage.now - begin, Milliseconds(3 * 200 + 2 * 500)) << "three tries 500 ms apart";
}

TEST(MotionLieDown, WithoutALimitGoesOnUntilItSucceeds) {
  Stage stage;
  stage.board.deaf = true;
  const auto token = stage.LieDown(kPassiveGetDown, 0);
  stage.RunFor(Milliseconds(60'000));
  EXPECT_THAT(stage.answers, IsEmpty());
  stage.board.deaf = false;
  EXPECT_EQ(stage.CodeOf(token), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(kPassiveGetDown));
}

TEST(MotionLieDown, ThatNobodyWaitsForAnyMoreIsGivenUpWith3007) {
  Stage stage;
  stage.board.deaf = true;
  const auto token = stage.LieDown(kGetDown, 0);
  stage.RunFor(Milliseconds(1000));
  stage.Do(motion_event::Cancelled{token});
  EXPECT_EQ(stage.CodeOf(token), 3007);
  const std::size_t before = stage.sent.size();
  stage.RunFor(Milliseconds(5000));
  EXPECT_EQ(stage.sent.size(), before);
}

TEST(MotionLieDown, KeepsOthersOutBetweenItsTries) {
  Stage stage;
  stage.board.deaf = true;
  stage.LieDown(kGetDown, 3);
  stage.RunFor(Milliseconds(300));
  EXPECT_EQ(stage.CodeOf(stage.Ask(111)), 3011);
  stage.Servo(303);
  EXPECT_EQ(stage.ServoCode(), 3011);
}

// --- Emergency stop

TEST(MotionEmergencyStop, IsSentAtOnceWhateverRuns) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  const auto stop = stage.Ask(kEmergencyStop);
  EXPECT_EQ(stage.sent.back().command.id, kEmergencyStop);
  EXPECT_EQ(stage.sent.back().at, stage.now);
  EXPECT_EQ(stage.ServoCode(), 3040);
  EXPECT_EQ(stage.CodeOf(stop), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(303, kEmergencyStop)) << "no WALK_STAND after it";
}

TEST(MotionEmergencyStop, EndsTheMotionOfAResultCommandWith3040) {
  Stage stage;
  const auto dance = stage.Ask(140);
  stage.RunFor(Milliseconds(200));
  stage.Ask(kEmergencyStop);
  EXPECT_EQ(stage.CodeOf(dance), 3040);
}

TEST(MotionEmergencyStop, LatchesUntilRecoveryStand) {
  Stage stage;
  ASSERT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop)), kCodeOk);
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3040);
  EXPECT_EQ(stage.CodeOf(stage.Ask(kGetDown)), 3040);
  stage.Servo(303);
  EXPECT_EQ(stage.ServoCode(), 3040);
  EXPECT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop)), kCodeOk) << "once more is fine";
  EXPECT_EQ(stage.CodeOf(stage.Ask(kRecoveryStand)), kCodeOk);
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), kCodeOk);
}

// In the original id 0 was refused with 3003 in every state but Active and Protected.
TEST(MotionEmergencyStop, IsTakenInEveryState) {
  for (const std::string_view state :
       {kUninitialized, kSetUp, kSelfCheck, kDeActive, kLowPower, kOta, kError, kTearDown}) {
    Stage stage;
    stage.core.closed = State(state);
    stage.refused[""] = kInvalid;
    EXPECT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop)), kCodeOk) << state;
    EXPECT_THAT(stage.Commanded(), ElementsAre(kEmergencyStop));
  }
}

TEST(MotionEmergencyStop, IsTakenFromWhoeverSendsIt) {
  for (const std::int32_t source : {-2, -1, 0, 4, 99, -99}) {
    Stage stage;
    EXPECT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop, source)), kCodeOk);
  }
}

TEST(MotionEmergencyStop, IsTakenWithNonsenseInIt) {
  Stage stage;
  MotionArguments arguments;
  arguments.vel_des = {std::numeric_limits<float>::quiet_NaN()};
  arguments.duration_ms = -5;
  EXPECT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop, 0, arguments)), kCodeOk);
  EXPECT_EQ(stage.sent.front().command.vel, (std::array<float, 3>{}));
}

TEST(MotionEmergencyStop, IsRepeatedUntilTheBoardTakesIt) {
  Stage stage;
  stage.board.deaf = true;
  EXPECT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop)), 3035)
      << "who asked is told that it is not sure";
  stage.RunFor(Milliseconds(10'000));
  EXPECT_GE(stage.sent.size(), 200U);
  stage.board.deaf = false;
  stage.RunFor(Milliseconds(100));
  const std::size_t before = stage.sent.size();
  stage.RunFor(Milliseconds(1000));
  EXPECT_EQ(stage.sent.size(), before);
}

TEST(MotionEmergencyStop, OfTheMachineIsTheSame) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.Do(motion_event::EmergencyStop{});
  EXPECT_EQ(stage.sent.back().command.id, kEmergencyStop);
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3040);
}

TEST(MotionEmergencyStop, OfTheMachineIsNotClearedWhileItIsEngaged) {
  Stage stage;
  stage.Do(motion_event::EmergencyStop{});
  stage.RunFor(Milliseconds(1000));
  stage.refused[""] = {3003, "an emergency stop is engaged"};
  EXPECT_EQ(stage.CodeOf(stage.Ask(kRecoveryStand)), 3003);
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3040);
  stage.refused.clear();
  EXPECT_EQ(stage.CodeOf(stage.Ask(kRecoveryStand)), kCodeOk);
  EXPECT_FALSE(stage.core.emergency_stop);
}

TEST(MotionEmergencyStop, LeavesABodyThatLiesToLowPower) {
  Stage stage;
  ASSERT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop)), kCodeOk);
  EXPECT_EQ(stage.CodeOf(stage.LieDown(kGetDown, 3)), kCodeOk);
}

TEST(MotionEmergencyStop, InTheMiddleOfAQueueStopsAtOnce) {
  Stage stage;
  stage.Play({{111, {}}, {kEmergencyStop, {}}});
  EXPECT_THAT(stage.Commanded(), ElementsAre(kEmergencyStop));
  EXPECT_TRUE(stage.core.emergency_stop);
}

}  // namespace musher::motion::testing::motion_state_test
