// The effect of the machine's state on motion: gating, emergency stop, lying down.

#include <gmock/gmock.h>

#include "musher/test/modules/motion/harness.hpp"

namespace musher::motion::testing::motion_state_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Error kInvalid{3003, "not in LowPower"};
const Error kProtected{3013, "the battery is low, charge it first"};

// --- Gating

TEST(MotionGate, RefusesAResultCommandWithTheCodeAndReasonOfItsCapability) {
  Harness harness;
  harness.refused["back_flip"] = kProtected;
  const auto token = harness.RequestMotion(121);
  EXPECT_EQ(harness.CodeOf(token), 3013);
  EXPECT_EQ(harness.answers.at(token).message, kProtected.message);
  EXPECT_THAT(harness.log, Contains(HasSubstr("the battery is low")));
  EXPECT_THAT(harness.sent, IsEmpty());
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(111)), kCodeOk)
      << "standing up is another capability";
}

TEST(MotionGate, RefusesAServoFrameWithOneResponse) {
  Harness harness;
  harness.refused["walk"] = kInvalid;
  harness.Servo(303);
  ASSERT_EQ(harness.responses.size(), 1U);
  EXPECT_EQ(harness.responses[0].code, 3003);
  EXPECT_FALSE(harness.responses[0].result);
  harness.RunFor(Milliseconds(500));
  EXPECT_THAT(harness.sent, IsEmpty());
}

TEST(MotionGate, StopsTheBodyWhenTheStateForbidsFurtherFrames) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.refused["walk"] = kInvalid;
  const Time then = harness.now;
  harness.Stream(303, Milliseconds(500));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, kWalkStand));
  EXPECT_LE(harness.sent.back().at, then + Milliseconds(250));
}

TEST(MotionGate, IsCheckedAgainWhenTheMotionBegins) {
  Harness harness;
  harness.Body(kGetDown);
  const auto token = harness.RequestMotion(121);
  harness.RunFor(Milliseconds(200));
  harness.refused["back_flip"] = kProtected;  // while it stands up for it
  EXPECT_EQ(harness.CodeOf(token), 3013);
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand));
}

TEST(MotionGate, IsCheckedAgainWhenAServoMotionBeginsAfterStandingUp) {
  Harness harness;
  harness.Body(kGetDown);
  harness.Servo(303);
  harness.refused["walk"] = kInvalid;
  for (int i = 0; i < 40; ++i) {
    harness.RunFor(Milliseconds(25));
    if (harness.core.servo) harness.core.servo->last_frame = harness.now;
  }
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand));
  EXPECT_FALSE(harness.core.servo);
}

TEST(MotionGate, IsShutBeforeTheFirstActive) {
  Harness harness;
  harness.core.closed = State(kUninitialized);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(111)), 3003);
  harness.Servo(303);
  EXPECT_EQ(harness.ServoCode(), 3003);
  EXPECT_THAT(harness.sent, IsEmpty());
}

// --- A state in which no motion is permitted

TEST(MotionState, ThatIsClosedStopsAWalkAtOnce) {
  for (const std::string_view state : {kDeActive, kError, kLowPower}) {
    Harness harness;
    harness.Stream(303, Milliseconds(500));
    harness.Do(motion_event::Closed{State(state)});
    EXPECT_EQ(harness.sent.back().command.id, kWalkStand);
    EXPECT_EQ(harness.sent.back().at, harness.now);
    harness.Servo(303);
    EXPECT_EQ(harness.ServoCode(), 3003);
  }
}

TEST(MotionState, ThatIsTearDownOrOtaSendsNoWalkStand) {
  for (const std::string_view state : {kTearDown, kOta}) {
    Harness harness;
    harness.Stream(303, Milliseconds(500));
    harness.Do(motion_event::Closed{State(state)});
    harness.RunFor(Milliseconds(500));
    EXPECT_THAT(harness.Commanded(), ElementsAre(303));
    EXPECT_TRUE(harness.core.Idle());
  }
}

TEST(MotionState, ThatIsErrorAnswersTheCallerWith3003AndInterruptsADance) {
  Harness harness;
  harness.board.motion = Milliseconds(60'000);
  const auto dance = harness.RequestMotion(140);
  harness.RunFor(Milliseconds(1000));
  harness.Do(motion_event::Closed{State(kError)});
  EXPECT_EQ(harness.CodeOf(dance), 3003);
  EXPECT_THAT(harness.Commanded(), ElementsAre(140, kRecoveryStand));
}

TEST(MotionState, ThatIsErrorLetsAFlipLand) {
  Harness harness;
  const auto flip = harness.RequestMotion(121);
  harness.RunFor(Milliseconds(200));
  harness.Do(motion_event::Closed{State(kError)});
  EXPECT_EQ(harness.CodeOf(flip), 3003);
  harness.RunFor(Milliseconds(1000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(121));
}

TEST(MotionState, ThatIsErrorEndsATimedWalkStanding) {
  Harness harness;
  MotionArguments arguments;
  arguments.duration_ms = 10'000;
  harness.board.motion = Milliseconds(10'000);
  harness.RequestMotion(303, 0, arguments);
  harness.RunFor(Milliseconds(1000));
  harness.Do(motion_event::Closed{State(kError)});
  EXPECT_EQ(harness.sent.back().command.id, kWalkStand);
}

TEST(MotionState, ThatIsActiveAgainMovesNothingByItself) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.Do(motion_event::Closed{State(kLowPower)});
  harness.RunFor(Milliseconds(500));
  ASSERT_EQ(harness.CodeOf(harness.LieDown(kGetDown, 3)), kCodeOk);
  const std::size_t before = harness.sent.size();
  harness.Do(motion_event::Opened{});
  harness.RunFor(Milliseconds(5000));
  EXPECT_EQ(harness.sent.size(), before);
}

// Its program ignores 3003, and may do so for hours.
TEST(MotionState, ThatWasLeftLetsNoStreamThatGoesOnMoveTheBodyInActive) {
  for (const std::string_view state : {kLowPower, kDeActive, kError}) {
    Harness harness;
    harness.Stream(303, Milliseconds(500));
    harness.Do(motion_event::Closed{State(state)});
    harness.Stream(303, Milliseconds(1000));
    if (state == kLowPower) {
      const RequestToken lies = harness.LieDown(kGetDown, 3);
      harness.Stream(303, Milliseconds(2000));
      EXPECT_EQ(harness.CodeOf(lies), kCodeOk);
    }
    harness.Stream(303, Milliseconds(1000));
    harness.Do(motion_event::Opened{});
    const std::size_t before = harness.sent.size();
    harness.Stream(303, Milliseconds(1000));
    EXPECT_EQ(harness.sent.size(), before) << state;
    EXPECT_EQ(harness.ServoCode(), 3003);
    harness.RunFor(Milliseconds(250));
    harness.Stream(303, Milliseconds(8000));
    EXPECT_EQ(harness.Commanded().back(), 303) << "after a pause";
  }
}

// As after a restart of the manager's process.
TEST(MotionState, ThatWasNotYetActiveLetsNoStreamThatGoesOnMoveTheBody) {
  Harness harness;
  harness.core.closed = State(kUninitialized);
  harness.Stream(303, Milliseconds(500));
  harness.Do(motion_event::Opened{});
  harness.Stream(303, Milliseconds(500));
  EXPECT_THAT(harness.sent, IsEmpty());
  harness.RunFor(Milliseconds(250));
  harness.Stream(303, Milliseconds(500));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303));
}

// Between two of its frames.
TEST(MotionState, ThatWasLeftForAMomentLetsNoStreamThatGoesOnMoveTheBody) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.Do(motion_event::Closed{State(kDeActive)});
  harness.Do(motion_event::Opened{});
  harness.Stream(303, Milliseconds(1000));
  EXPECT_EQ(harness.Commanded().back(), kWalkStand);
  EXPECT_EQ(harness.ServoCode(), 3003);
}

// Its end frees it, as after each interruption.
TEST(MotionState, ThatWasLeftLetsAStreamThatBeginsOnMoveTheBody) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.Do(motion_event::Closed{State(kDeActive)});
  harness.Stream(303, Milliseconds(500));
  harness.Servo(303, 0, {}, ServoCommand::kEnd);
  harness.Do(motion_event::Opened{});
  harness.Stream(303, Milliseconds(500));
  EXPECT_EQ(harness.Commanded().back(), 303);
}

// --- Lying down

TEST(MotionLieDown, TakesTheBodyDownFromStanding) {
  Harness harness;
  EXPECT_EQ(harness.CodeOf(harness.LieDown(kGetDown, 3)), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(kGetDown));
}

TEST(MotionLieDown, DoesNothingWhereTheBodyLiesAlready) {
  for (const std::int32_t lying : {kEmergencyStop, kGetDown, kPassiveGetDown}) {
    Harness harness;
    harness.Body(lying);
    EXPECT_EQ(harness.CodeOf(harness.LieDown(kPassiveGetDown, 0)), kCodeOk);
    EXPECT_THAT(harness.sent, IsEmpty());
  }
}

TEST(MotionLieDown, IsNotBlockedByTheStateOrByTheControllingSource) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.Do(motion_event::Closed{State(kOta)});
  harness.refused[""] = kInvalid;
  EXPECT_EQ(harness.CodeOf(harness.LieDown(kGetDown, 0)), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, kGetDown));
}

TEST(MotionLieDown, InterruptsAnything) {
  Harness harness;
  const auto flip = harness.RequestMotion(121);
  harness.RunFor(Milliseconds(100));
  EXPECT_EQ(harness.CodeOf(harness.LieDown(kGetDown, 3)), kCodeOk);
  EXPECT_EQ(harness.CodeOf(flip), 3003);
}

// In the original the state callback reported success whether the body lay or not.
TEST(MotionLieDown, ThatFailsThreeTimesIsReported) {
  Harness harness;
  harness.board.deaf = true;
  const Time begin = harness.now;
  EXPECT_EQ(harness.CodeOf(harness.LieDown(kGetDown, 3)), 3035);
  EXPECT_EQ(harness.now - begin, Milliseconds(3 * 200 + 2 * 500)) << "three tries 500 ms apart";
}

TEST(MotionLieDown, WithoutALimitContinuesUntilItSucceeds) {
  Harness harness;
  harness.board.deaf = true;
  const auto token = harness.LieDown(kPassiveGetDown, 0);
  harness.RunFor(Milliseconds(60'000));
  EXPECT_THAT(harness.answers, IsEmpty());
  harness.board.deaf = false;
  EXPECT_EQ(harness.CodeOf(token), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(kPassiveGetDown));
}

TEST(MotionLieDown, ThatIsCancelledEndsWith3007) {
  Harness harness;
  harness.board.deaf = true;
  const auto token = harness.LieDown(kGetDown, 0);
  harness.RunFor(Milliseconds(1000));
  harness.Do(motion_event::Cancelled{token});
  EXPECT_EQ(harness.CodeOf(token), 3007);
  const std::size_t before = harness.sent.size();
  harness.RunFor(Milliseconds(5000));
  EXPECT_EQ(harness.sent.size(), before);
}

TEST(MotionLieDown, BlocksOtherSourcesBetweenItsTries) {
  Harness harness;
  harness.board.deaf = true;
  harness.LieDown(kGetDown, 3);
  harness.RunFor(Milliseconds(300));
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(111)), 3011);
  harness.Servo(303);
  EXPECT_EQ(harness.ServoCode(), 3011);
}

// --- Emergency stop

TEST(MotionEmergencyStop, IsSentAtOnceWhateverRuns) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  const auto stop = harness.RequestMotion(kEmergencyStop);
  EXPECT_EQ(harness.sent.back().command.id, kEmergencyStop);
  EXPECT_EQ(harness.sent.back().at, harness.now);
  EXPECT_EQ(harness.ServoCode(), 3040);
  EXPECT_EQ(harness.CodeOf(stop), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, kEmergencyStop)) << "no WALK_STAND after it";
}

TEST(MotionEmergencyStop, EndsTheMotionOfAResultCommandWith3040) {
  Harness harness;
  const auto dance = harness.RequestMotion(140);
  harness.RunFor(Milliseconds(200));
  harness.RequestMotion(kEmergencyStop);
  EXPECT_EQ(harness.CodeOf(dance), 3040);
}

TEST(MotionEmergencyStop, LatchesUntilRecoveryStand) {
  Harness harness;
  ASSERT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3040);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kGetDown)), 3040);
  harness.Servo(303);
  EXPECT_EQ(harness.ServoCode(), 3040);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk) << "once more is fine";
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), kCodeOk);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), kCodeOk);
}

// A manager that was started again does not know of the stop before.
TEST(MotionEmergencyStop, IsLatchedWhenTheFirstReportShowsABodyThatIsStopped) {
  for (const bool status : {true, false}) {
    Harness harness;
    harness.core = MotionCore();
    harness.Do(motion_event::Opened{});
    harness.board.report.mode = status ? std::int8_t{12} : std::int8_t{0};
    harness.board.report.gait = 0;
    harness.board.report.switch_status = status ? std::int8_t{2} : std::int8_t{0};
    harness.Do(motion_event::BoardReported{harness.board.report});
    harness.Stream(303, Milliseconds(500));
    EXPECT_THAT(harness.sent, IsEmpty()) << "it neither stands up nor walks";
    EXPECT_EQ(harness.ServoCode(), 3040);
    harness.RunFor(Milliseconds(300));
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), kCodeOk);
    harness.Stream(303, Milliseconds(500));
    EXPECT_EQ(harness.Commanded().back(), 303);
  }
}

// By remote control, by the board itself, or because it has lost its balance.
TEST(MotionEmergencyStop, IsLatchedWhenTheBodyIsStoppedAtItsBoard) {
  struct Case {
    std::int8_t mode;
    std::int8_t status;
  };
  for (const auto& [mode, status] :
       {Case{0, 0}, Case{0, 2}, Case{12, 2}, Case{7, 3}, Case{11, 3}}) {
    SCOPED_TRACE(::testing::Message() << "mode " << int{mode} << " status " << int{status});
    Harness harness;
    harness.Stream(303, Milliseconds(500));
    const auto stop = [&] {
      harness.board = Board();
      harness.board.report = BodyReport{};
      harness.board.report.mode = mode;
      harness.board.report.switch_status = status;
      harness.board.report.bar = 100;
    };
    stop();
    harness.RunFor(Milliseconds(20));
    const std::size_t before = harness.sent.size();
    harness.Stream(303, Milliseconds(1000));
    harness.RunFor(Milliseconds(500));
    harness.Stream(303, Milliseconds(1000));
    EXPECT_EQ(harness.sent.size(), before) << "it neither stands up nor walks";
    EXPECT_EQ(harness.ServoCode(), 3040);
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3040);
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), kCodeOk);
    const auto jump = harness.RequestMotion(132);
    harness.RunFor(Milliseconds(50));
    stop();
    EXPECT_NE(harness.CodeOf(jump), kCodeOk);
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3040) << "a second one";
  }
}

// While the remote control holds the body, for example.
TEST(MotionEmergencyStop, HoldsWhereTheBoardHasNotTakenRecoveryStand) {
  Harness harness;
  ASSERT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk);
  harness.board.deaf = true;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), 3021);
  const std::size_t before = harness.sent.size();
  harness.Stream(303, Milliseconds(500));
  EXPECT_EQ(harness.ServoCode(), 3040);
  EXPECT_EQ(harness.sent.size(), before) << "it does not stand up for the stream";
  harness.board.deaf = false;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), kCodeOk);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), kCodeOk);
}

// A stick that is released, an app that is closed: the stream that went on was taken, and the body
// walked.
TEST(MotionEmergencyStop, IsNotEndedForAStreamByTheEndOfAnotherSourcesStream) {
  constexpr std::int32_t kOther = 4;
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.RequestMotion(kEmergencyStop);
  harness.RunFor(Milliseconds(40));
  harness.Stream(303, Milliseconds(1000));
  harness.RequestMotion(kRecoveryStand);
  harness.Stream(303, Milliseconds(500));
  harness.Servo(303, kOther, {}, ServoCommand::kEnd);
  harness.Stream(303, Milliseconds(2500));
  EXPECT_EQ(harness.Commanded().back(), kRecoveryStand);
}

// The app had sent frames, too, which were refused.
TEST(MotionEmergencyStop, IsNotEndedForAStreamByTheEndOfAnotherOneThatWasRefusedWithIt) {
  constexpr std::int32_t kOther = 4;
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.RequestMotion(kEmergencyStop);
  harness.RunFor(Milliseconds(40));
  harness.Stream(303, Milliseconds(1000));
  harness.RequestMotion(kRecoveryStand);
  harness.Stream(303, Milliseconds(2500));
  harness.Servo(303, kOther);
  harness.Servo(303, kOther, {}, ServoCommand::kEnd);
  harness.Stream(303, Milliseconds(1000));
  EXPECT_EQ(harness.Commanded().back(), kRecoveryStand);
  harness.Servo(303, 0, {}, ServoCommand::kEnd);
  harness.Stream(303, Milliseconds(500));
  EXPECT_EQ(harness.Commanded().back(), 303) << "all have ended";
}

// Also one that has begun since then.
TEST(MotionEmergencyStop, EndsAStreamThatHasToPauseOnceTheBodyStandsAgain) {
  for (const std::string stop : {"own", "of the board", "before the stream"}) {
    SCOPED_TRACE(stop);
    Harness harness;
    if (stop != "before the stream") harness.Stream(303, Milliseconds(500));
    if (stop == "of the board") {
      harness.board = Board();
      harness.Body(kEmergencyStop);
    } else {
      harness.RequestMotion(kEmergencyStop);
    }
    harness.RunFor(stop == "before the stream" ? Milliseconds(1000) : Milliseconds(40));
    harness.Stream(303, Milliseconds(1000));
    const auto stands = harness.RequestMotion(kRecoveryStand);
    harness.Stream(303, Milliseconds(3000));
    EXPECT_EQ(harness.CodeOf(stands), kCodeOk);
    EXPECT_EQ(harness.Commanded().back(), kRecoveryStand) << "it does not walk at once";
    EXPECT_EQ(harness.ServoCode(), 3040);
    harness.RunFor(kServoWatchdog);
    harness.Stream(303, Milliseconds(500));
    EXPECT_EQ(harness.Commanded().back(), 303);
  }
}

// Within the 200 ms in which its caller waits.
TEST(MotionEmergencyStop, IsRepeatedUntilItIsTakenWhateverTheMachineDoesMeanwhile) {
  const std::vector<std::vector<MotionEvent>> cases = {
      {motion_event::Closed{State(kError)}},
      {motion_event::Closed{State(kLowPower)}, motion_event::LieDown{99, kGetDown, 3}},
      {motion_event::LieDown{99, kPassiveGetDown, 0}},
      {motion_event::WorldRestarted{}}};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE(i);
    Harness harness;
    harness.board.deaf = true;
    harness.RequestMotion(kEmergencyStop);
    harness.RunFor(Milliseconds(50));
    for (const MotionEvent& event : cases[i]) harness.Do(event);
    harness.RunFor(Milliseconds(1000));
    harness.board.deaf = false;
    harness.RunFor(Milliseconds(200));
    EXPECT_EQ(harness.board.report.mode, 0);
    EXPECT_THAT(harness.Commanded(), ElementsAre(kEmergencyStop));
    if (i == 1 || i == 2) {
      EXPECT_EQ(harness.CodeOf(99), kCodeOk) << "the body lies by the stop";
    }
    harness.RunFor(Milliseconds(1000));
    EXPECT_TRUE(harness.core.Idle());
    EXPECT_FALSE(harness.core.link.active);
  }
}

// Motion 0 would take the power from a body that its board damps.
TEST(MotionEmergencyStop, ThatTheBoardHasSetIsKeptWithoutACommandWhenTheWorldRestarts) {
  Harness harness;
  harness.board.report.mode = 7;
  harness.board.report.gait = 1;
  harness.board.report.switch_status = 3;
  harness.RunFor(Milliseconds(100));
  harness.Do(motion_event::WorldRestarted{});
  harness.RunFor(Milliseconds(100));
  EXPECT_THAT(harness.sent, IsEmpty());
  harness.board.report.switch_status = 0;
  harness.Body(kRecoveryStand);
  harness.Stream(303, Milliseconds(500));
  EXPECT_THAT(harness.sent, IsEmpty()) << "it stays stopped";
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3040);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), kCodeOk);
}

TEST(MotionEmergencyStop, ThatTheBoardHasSetIsCommandedAgainOnceItHasBeenCommanded) {
  Harness harness;
  harness.board.report.mode = 7;
  harness.board.report.gait = 1;
  harness.board.report.switch_status = 3;
  harness.RunFor(Milliseconds(100));
  harness.Do(motion_event::EmergencyStop{});
  harness.RunFor(Milliseconds(1000));
  harness.sent.clear();
  harness.Do(motion_event::WorldRestarted{});
  EXPECT_THAT(harness.Commanded(), ElementsAre(kEmergencyStop));
}

// The board gives up before the body lies.
TEST(MotionEmergencyStop, IsRepeatedAlsoAfterALieDownThatHasFailed) {
  Harness harness;
  harness.board.deaf = true;
  harness.RequestMotion(kEmergencyStop);
  EXPECT_EQ(harness.CodeOf(harness.LieDown(kGetDown, 3)), 3040);
  harness.RunFor(Milliseconds(1000));
  harness.board.deaf = false;
  harness.RunFor(Milliseconds(200));
  EXPECT_EQ(harness.board.report.mode, 0);
}

// In its damping it is on its way down.
TEST(MotionEmergencyStop, OfABodyInDampingLetsTheMachineLieDown) {
  for (const int tries : {3, 0}) {
    Harness harness;
    harness.board = Board();
    harness.board.report.mode = 7;
    harness.board.report.gait = 1;
    harness.board.report.bar = 30;
    harness.board.report.switch_status = 3;
    harness.RunFor(Milliseconds(20));
    const auto lies = harness.LieDown(kGetDown, tries);
    harness.RunFor(Milliseconds(3000));
    EXPECT_THAT(harness.answers, IsEmpty());
    harness.board.report.bar = 100;
    EXPECT_EQ(harness.CodeOf(lies), kCodeOk);
    EXPECT_THAT(harness.sent, IsEmpty());
  }
}

// The progress that its board reports may be that of the motion before: the lie-down waited for
// all of the state's time.
TEST(MotionEmergencyStop, OfABodyInDampingLetsTheMachineLieDownWithAnOldProgress) {
  for (const int tries : {3, 0}) {
    Harness harness;
    harness.board = Board();
    harness.board.report.mode = 7;
    harness.board.report.gait = 1;
    harness.board.report.bar = 30;
    harness.board.report.switch_status = 3;
    harness.RunFor(Milliseconds(20));
    const auto lies = harness.LieDown(kGetDown, tries);
    harness.RunFor(Milliseconds(3000));
    harness.board.report.bar = 40;
    harness.RunFor(Milliseconds(4900));
    EXPECT_THAT(harness.answers, IsEmpty()) << "it went on 4900 ms ago";
    harness.RunFor(Milliseconds(700));
    ASSERT_EQ(harness.answers.count(lies), 1U);
    EXPECT_EQ(harness.answers.at(lies).code, kCodeOk);
    const auto again = harness.LieDown(kPassiveGetDown, tries);
    EXPECT_EQ(harness.answers.count(again), 1U) << "it lies already";
    EXPECT_THAT(harness.sent, IsEmpty()) << "it is not stood up";
  }
}

TEST(MotionEmergencyStop, OfABodyInDampingCountsNoTimeInWhichItsBoardIsSilent) {
  Harness harness;
  harness.board = Board();
  harness.board.report.mode = 7;
  harness.board.report.gait = 1;
  harness.board.report.switch_status = 3;
  harness.board.report.bar = 30;
  harness.RunFor(Milliseconds(3000));
  harness.board.silent = true;
  harness.RunFor(Milliseconds(3000));
  harness.board.silent = false;
  const auto lies = harness.LieDown(kGetDown, 0);
  harness.RunFor(Milliseconds(4000));
  EXPECT_THAT(harness.answers, IsEmpty());
  EXPECT_EQ(harness.CodeOf(lies), kCodeOk);
}

// The lie-down was in progress; the board reports no motion of the table.
TEST(MotionEmergencyStop, AtTheBoardStandsNoBodyUpThatIsToLieDown) {
  Harness harness;
  harness.Body(140);  // recovery stand comes first
  const auto lies = harness.LieDown(kGetDown, 0);
  harness.RunFor(Milliseconds(50));
  const std::size_t before = harness.sent.size();
  harness.board = Board();
  harness.board.report.mode = 7;
  harness.board.report.gait = 99;
  harness.board.report.switch_status = 3;
  harness.RunFor(Milliseconds(3000));
  EXPECT_EQ(harness.sent.size(), before) << "neither repeated nor sent once more";
  EXPECT_THAT(harness.answers, IsEmpty());
  harness.board.report.gait = 1;
  harness.board.report.bar = 100;
  EXPECT_EQ(harness.CodeOf(lies), kCodeOk);
}

// As by remote control, or by a recovery stand whose answer a state change has dropped.
TEST(MotionEmergencyStop, LetsTheMachineLieDownFromANormalStand) {
  Harness harness;
  ASSERT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk);
  harness.board = Board();
  harness.Body(kRecoveryStand);
  EXPECT_EQ(harness.CodeOf(harness.LieDown(kGetDown, 3)), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(kEmergencyStop, kGetDown));
}

TEST(MotionEmergencyStop, AtTheBoardLetsTheMachineLieDown) {
  Harness harness;
  const auto lies = harness.LieDown(kGetDown, 3);
  harness.RunFor(Milliseconds(150));
  harness.board = Board();
  harness.board.report.mode = 7;
  harness.board.report.gait = 1;
  harness.board.report.bar = 100;
  harness.board.report.switch_status = 3;
  EXPECT_EQ(harness.CodeOf(lies), kCodeOk);
}

// In the original id 0 was refused with 3003 in every state but Active and Protected.
TEST(MotionEmergencyStop, IsTakenInEveryState) {
  for (const std::string_view state :
       {kUninitialized, kSetUp, kSelfCheck, kDeActive, kLowPower, kOta, kError, kTearDown}) {
    Harness harness;
    harness.core.closed = State(state);
    harness.refused[""] = kInvalid;
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk) << state;
    EXPECT_THAT(harness.Commanded(), ElementsAre(kEmergencyStop));
  }
}

TEST(MotionEmergencyStop, IsTakenFromEverySource) {
  for (const std::int32_t source : {-2, -1, 0, 4, 99, -99}) {
    Harness harness;
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop, source)), kCodeOk);
  }
}

TEST(MotionEmergencyStop, IsTakenWithInvalidArguments) {
  Harness harness;
  MotionArguments arguments;
  arguments.vel_des = {std::numeric_limits<float>::quiet_NaN()};
  arguments.duration_ms = -5;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop, 0, arguments)), kCodeOk);
  EXPECT_EQ(harness.sent.front().command.vel, (std::array<float, 3>{}));
}

TEST(MotionEmergencyStop, IsRepeatedUntilTheBoardTakesIt) {
  Harness harness;
  harness.board.deaf = true;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), 3035)
      << "the caller learns that it is uncertain";
  harness.RunFor(Milliseconds(10'000));
  EXPECT_GE(harness.sent.size(), 200U);
  harness.board.deaf = false;
  harness.RunFor(Milliseconds(100));
  const std::size_t before = harness.sent.size();
  harness.RunFor(Milliseconds(1000));
  EXPECT_EQ(harness.sent.size(), before);
}

TEST(MotionEmergencyStop, OfTheMachineIsTheSame) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.Do(motion_event::EmergencyStop{});
  EXPECT_EQ(harness.sent.back().command.id, kEmergencyStop);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3040);
}

TEST(MotionEmergencyStop, OfTheMachineIsNotClearedWhileItIsEngaged) {
  Harness harness;
  harness.Do(motion_event::EmergencyStop{});
  harness.RunFor(Milliseconds(1000));
  harness.refused[""] = {3003, "an emergency stop is engaged"};
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), 3003);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3040);
  harness.refused.clear();
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), kCodeOk);
  EXPECT_FALSE(harness.core.emergency_stop);
}

TEST(MotionEmergencyStop, LeavesABodyThatLiesToLowPower) {
  Harness harness;
  ASSERT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk);
  EXPECT_EQ(harness.CodeOf(harness.LieDown(kGetDown, 3)), kCodeOk);
}

TEST(MotionEmergencyStop, InTheMiddleOfAQueueStopsAtOnce) {
  Harness harness;
  harness.Play({{111, {}}, {kEmergencyStop, {}}});
  EXPECT_THAT(harness.Commanded(), ElementsAre(kEmergencyStop));
  EXPECT_TRUE(harness.core.emergency_stop);
}

}  // namespace musher::motion::testing::motion_state_test
