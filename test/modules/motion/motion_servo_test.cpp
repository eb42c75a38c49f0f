// Servo commands: which source controls the body, the watchdog, the responses to the streamer.

#include <gmock/gmock.h>

#include <limits>
#include <set>
#include <tuple>

#include "musher/test/modules/motion/harness.hpp"

namespace musher::motion::testing::motion_servo_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::array<float, 3> kStill{};

TEST(MotionServo, MovesTheBodyAsLongAsFramesCome) {
  Harness harness;
  harness.Stream(303, Milliseconds(2000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303));
  EXPECT_EQ(harness.ServoCode(), kCodeOk);
  EXPECT_EQ(harness.sent.back().command.vel, (std::array<float, 3>{0.2F, 0, 0}));
}

TEST(MotionServo, ReachesTheBoardWithItsFirstFrame) {
  Harness harness;
  harness.Servo(303);
  ASSERT_EQ(harness.sent.size(), 1U);
  EXPECT_EQ(harness.sent[0].at, harness.now);
}

// At first it waited up to 50 ms for the next frame of 20 Hz.
TEST(MotionServo, ReachesTheBoardAtOnceWhenItChanges) {
  Harness harness;
  for (int i = 0; i < 20; ++i) {
    harness.Servo(303, 0, {0.01F * static_cast<float>(i), 0, 0});
    EXPECT_EQ(harness.sent.back().at, harness.now);
    EXPECT_EQ(harness.sent.back().command.vel[0], 0.01F * static_cast<float>(i));
    harness.RunFor(Milliseconds(7));
  }
  EXPECT_EQ(harness.sent.size(), 20U);
}

TEST(MotionServo, ReachesTheBoardAt20HzHoweverFastEqualFramesCome) {
  Harness harness;
  for (int i = 0; i < 500; ++i) {
    harness.Servo(303);
    harness.RunFor(Milliseconds(2));
  }
  EXPECT_NEAR(static_cast<double>(harness.sent.size()), 20, 1);
}

TEST(MotionServo, ReachesTheBoardAt500HzAtMostAndTheNewestFrameCounts) {
  Harness harness;
  const Time begin = harness.now;
  for (int i = 0; i < 4000; ++i) {
    harness.Servo(303, 0, {1e-4F * static_cast<float>(i), 0, 0});
    harness.RunFor(std::chrono::microseconds(250));
  }
  EXPECT_EQ(harness.now - begin, Milliseconds(1000));
  EXPECT_NEAR(static_cast<double>(harness.sent.size()), 501, 1);
  for (std::size_t i = 2; i < harness.sent.size(); ++i) {
    ASSERT_GE(harness.sent[i].at - harness.sent[i - 2].at, Milliseconds(2));
  }
  harness.RunFor(Milliseconds(2));
  EXPECT_EQ(harness.sent.back().command.vel[0], 1e-4F * 3999) << "the last one is sent, too";
}

TEST(MotionServo, IsRepeated20TimesASecondBetweenItsChanges) {
  Harness harness;
  harness.Servo(303, 0, {0.1F, 0, 0});
  harness.RunFor(Milliseconds(30));
  harness.Servo(303);
  const Time changed = harness.now;
  harness.RunFor(Milliseconds(120));
  ASSERT_EQ(harness.sent.size(), 4U);
  EXPECT_EQ(harness.sent[2].at, changed + Milliseconds(50));
  EXPECT_EQ(harness.sent[3].at, changed + Milliseconds(100));
}

TEST(MotionServo, ReachesTheBoardAtOnceAfterARepetition) {
  Harness harness;
  harness.Servo(303, 0, {0.1F, 0, 0});
  harness.RunFor(Milliseconds(51));
  ASSERT_EQ(harness.sent.size(), 2U);
  harness.Servo(303);
  EXPECT_EQ(harness.sent.back().at, harness.now);
  EXPECT_EQ(harness.sent.back().command.vel[0], 0.2F);
}

// Whatever was sent just before.
TEST(MotionServo, IsStoppedAtOnceHoweverFastItsFramesCome) {
  Harness harness;
  harness.Servo(303, 0, {0.1F, 0, 0});
  harness.RunFor(Milliseconds(1));
  harness.Servo(303);
  harness.Servo(303, 0, {}, ServoCommand::kEnd);
  EXPECT_EQ(harness.sent.back().command.id, kWalkStand);
  EXPECT_EQ(harness.sent.back().at, harness.now);
}

TEST(MotionServo, ReachesTheBoardAtOnceAfterManyBeginsAndStops) {
  Harness harness;
  for (int i = 0; i < 100; ++i) {
    harness.Servo(303);
    harness.Servo(303, 0, {}, ServoCommand::kEnd);
  }
  harness.Servo(303, 0, {0.1F, 0, 0});
  harness.Servo(303, 0, {0.3F, 0, 0});
  harness.RunFor(Milliseconds(2));
  EXPECT_EQ(harness.sent.back().command.vel[0], 0.3F);
}

TEST(MotionServo, ReachesTheBoardAt500HzAtMostAlsoWhenEachFrameHasAnotherMotion) {
  Harness harness;
  harness.Stream(303, Milliseconds(1000));
  harness.sent.clear();
  for (int i = 0; i < 4000; ++i) {
    harness.Servo(i % 2 == 0 ? 305 : 303);
    harness.RunFor(std::chrono::microseconds(250));
  }
  EXPECT_LE(harness.sent.size(), 502U);
  for (std::size_t i = 2; i < harness.sent.size(); ++i) {
    ASSERT_GE(harness.sent[i].at - harness.sent[i - 2].at, Milliseconds(2));
  }
  for (int i = 0; i < 20; ++i) {
    harness.Servo(305);
    harness.RunFor(std::chrono::microseconds(250));
  }
  EXPECT_EQ(harness.sent.back().command.id, 305) << "the one that goes on begins";
}

// As of a simulation that begins again.
TEST(MotionServo, ReachesTheBoardAtOnceAfterTimeHasGoneBack) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.now = Time{std::chrono::seconds(1)};
  harness.Do(motion_event::WorldRestarted{});
  harness.Body(kRecoveryStand);
  for (const float speed : {0.1F, 0.3F}) {
    harness.now += Milliseconds(10);
    harness.Servo(303, 0, {speed, 0, 0});
    EXPECT_EQ(harness.sent.back().at, harness.now);
    EXPECT_EQ(harness.sent.back().command.vel[0], speed);
  }
}

TEST(MotionServo, TakesFramesOfTypeStartLikeData) {
  Harness harness;
  harness.Servo(303, 0, {0.2F, 0, 0}, ServoCommand::kStart);
  EXPECT_THAT(harness.Commanded(), ElementsAre(303));
}

TEST(MotionServo, StopsTheBodyAfterEnd) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.Servo(303, 0, {}, ServoCommand::kEnd);
  EXPECT_EQ(harness.sent.back().at, harness.now);
  EXPECT_EQ(harness.sent.back().command.id, kWalkStand);
  EXPECT_EQ(harness.sent.back().command.vel, kStill);
  EXPECT_TRUE(harness.core.Idle());
  EXPECT_EQ(harness.ServoCode(), kCodeOk);
}

TEST(MotionServo, StopsTheBody200msAfterTheLastFrame) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.Servo(303);
  const Time last = harness.now;
  harness.RunFor(Milliseconds(199));
  EXPECT_EQ(harness.sent.back().command.id, 303);
  harness.RunFor(Milliseconds(1));
  EXPECT_EQ(harness.sent.back().command.id, kWalkStand);
  EXPECT_EQ(harness.sent.back().at, last + Milliseconds(200));
  EXPECT_TRUE(harness.core.Idle()) << "the next source gets control";
  EXPECT_THAT(harness.log, Contains(HasSubstr("no frame for 200 ms")));
}

// A program that was suspended received nothing meanwhile; that is no fault of the stream.
TEST(MotionServo, ContinuesWhenItsFramesWereOnlyQueued) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.StandStill(Milliseconds(700));
  harness.Stream(303, Milliseconds(500));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303));
  EXPECT_THAT(harness.log, IsEmpty());
  EXPECT_EQ(harness.ServoCode(), kCodeOk);
}

TEST(MotionServo, IsStoppedAtTheSecondCheckWhenNoFrameWasQueued) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.StandStill(Milliseconds(700));
  EXPECT_TRUE(harness.core.servo);
  harness.StandStill(Milliseconds(700));
  EXPECT_EQ(harness.sent.back().command.id, kWalkStand) << "however late that is";
  EXPECT_TRUE(harness.core.Idle());
}

// A body that lay stood up for a stream that was over.
TEST(MotionServo, BeginsByNoFrameThatMayBeLate) {
  Harness harness;
  harness.Body(kGetDown);
  ServoCommand command;
  command.requested.id = 303;
  command.requested.arguments.vel_des = {0.3F, 0, 0};
  harness.Do(motion_event::ServoArrived{command, std::chrono::seconds(9)});
  harness.RunFor(Milliseconds(2000));
  EXPECT_EQ(harness.ServoCode(), MotionCode(KeyCode::kTimeout));
  EXPECT_THAT(harness.Commanded(), IsEmpty());
  harness.Stream(303, Milliseconds(5000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand, 303));
  command.requested.arguments.vel_des = {0.1F, 0, 0};
  harness.Do(motion_event::ServoArrived{command, std::chrono::seconds(9)});
  EXPECT_EQ(harness.ServoCode(), kCodeOk) << "the body follows it already";
  command.type = ServoCommand::kEnd;
  harness.Do(motion_event::ServoArrived{command, std::chrono::seconds(9)});
  EXPECT_TRUE(harness.core.Idle());
}

TEST(MotionServo, IsStoppedWithItsLastValueAndStepHeight) {
  Harness harness;
  ServoCommand command;
  command.requested.id = 303;
  command.requested.arguments.vel_des = {0.3F, 0, 0};
  command.requested.arguments.step_height = {0.05F, 0.06F};
  command.requested.arguments.value = 2;
  harness.Do(motion_event::ServoArrived{command});
  harness.RunFor(Milliseconds(300));
  EXPECT_EQ(harness.sent.back().command.id, kWalkStand);
  EXPECT_EQ(harness.sent.back().command.value, 2);
  EXPECT_EQ(harness.sent.back().command.step_height, (std::array<float, 2>{0.05F, 0.06F}));
}

TEST(MotionServo, OfForceControl201EndsWithoutWalkStand) {
  Harness harness;
  harness.Stream(201, Milliseconds(300));
  harness.RunFor(Milliseconds(1000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(201));
  EXPECT_TRUE(harness.core.Idle());
}

TEST(MotionServo, RepeatsItsStopUntilTheBoardTakesItButNotForEver) {
  Harness harness;
  harness.Stream(303, Milliseconds(300));
  harness.board.deaf = true;
  harness.Servo(303, 0, {}, ServoCommand::kEnd);
  const std::size_t before = harness.sent.size();
  harness.RunFor(Milliseconds(3000));
  EXPECT_NEAR(static_cast<double>(harness.sent.size() - before), 20, 1);
  Harness connected;
  connected.Stream(303, Milliseconds(300));
  connected.Servo(303, 0, {}, ServoCommand::kEnd);
  const std::size_t then = connected.sent.size();
  connected.RunFor(Milliseconds(3000));
  EXPECT_LE(connected.sent.size(), then + 1);
}

TEST(MotionServo, GoesThroughRecoveryStandWhereTheBodyLies) {
  Harness harness;
  harness.Body(kGetDown);
  harness.Stream(303, Milliseconds(2000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand, 303));
}

TEST(MotionServo, DoesNotBeginWhenTheStreamEndsDuringTheRecoveryStand) {
  Harness harness;
  harness.Body(kGetDown);
  harness.Servo(303);
  harness.RunFor(Milliseconds(2000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand));
  EXPECT_TRUE(harness.core.Idle());
}

// At first its next frame was refused, and the streamer gave up.
TEST(MotionServo, ResumesAStreamThatStalledWhileTheBodyStandsUpForIt) {
  Harness harness;
  harness.Body(kGetDown);
  harness.Servo(303);
  harness.RunFor(Milliseconds(250));
  ASSERT_FALSE(harness.core.servo) << "the watchdog";
  ASSERT_TRUE(harness.core.job) << "it still stands up";
  harness.Servo(303, kFromDebug);
  EXPECT_EQ(harness.ServoCode(), 3011) << "to others the body is busy";
  harness.Servo(303);
  EXPECT_EQ(harness.ServoCode(), kCodeOk);
  EXPECT_TRUE(harness.core.servo && harness.core.job) << "and it waits again for the same stand";
  harness.Stream(303, Milliseconds(2000));
  EXPECT_EQ(harness.ServoCode(), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand, 303));
}

TEST(MotionServo, IsDroppedWhenTheRecoveryStandFails) {
  Harness harness;
  harness.Body(kGetDown);
  harness.board.fault = 10;  // stand stuck
  harness.Servo(303);
  harness.RunFor(Milliseconds(190));
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand));
  EXPECT_EQ(harness.ServoCode(), 3052);
  EXPECT_TRUE(harness.core.Idle());
}

TEST(MotionServo, OfAnotherGaitChangesOver) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.Stream(305, Milliseconds(500));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, 305));
}

TEST(MotionServo, WhileAResultCommandRunsIsRefusedWith3011) {
  Harness harness;
  const auto flip = harness.RequestMotion(121);
  harness.RunFor(Milliseconds(100));
  harness.Servo(303);
  EXPECT_EQ(harness.ServoCode(), 3011);
  EXPECT_EQ(harness.CodeOf(flip), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(121));
}

struct BadFrame {
  const char* name;
  ServoCommand command;
  std::int32_t code;
};

ServoCommand Frame(std::int32_t id, std::int32_t source, std::vector<float> vel,
                   std::int32_t type = ServoCommand::kData) {
  ServoCommand command;
  command.type = type;
  command.source = source;
  command.requested.id = id;
  command.requested.arguments.vel_des = std::move(vel);
  return command;
}

ServoCommand FrameWith(std::vector<float> MotionArguments::*field, std::vector<float> values) {
  ServoCommand command = Frame(303, 0, {0.1F, 0, 0});
  command.requested.arguments.*field = std::move(values);
  return command;
}

class BadServo : public ::testing::TestWithParam<BadFrame> {};

TEST_P(BadServo, IsRefusedWithItsCodeALogLineAndNothingMoves) {
  Harness harness;
  harness.Do(motion_event::ServoArrived{GetParam().command});
  EXPECT_EQ(harness.ServoCode(), GetParam().code);
  EXPECT_FALSE(harness.responses.back().result) << "a refusal never reports success";
  EXPECT_EQ(harness.LogLines(), 1U);
  harness.RunFor(Milliseconds(500));
  EXPECT_THAT(harness.sent, IsEmpty());
}

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

INSTANTIATE_TEST_SUITE_P(
    All, BadServo,
    ::testing::Values(
        BadFrame{"UnknownId", Frame(7777, 0, {0, 0, 0}), 3008},
        BadFrame{"NegativeId", Frame(-1, 0, {0, 0, 0}), 3008},
        BadFrame{"NoServoMotion", Frame(121, 0, {0, 0, 0}), 3008},
        BadFrame{"EmergencyStopIsNoServoMotion", Frame(0, 0, {}), 3008},
        BadFrame{"UnknownSource", Frame(303, 17, {0, 0, 0}), 3010},
        BadFrame{"TheMachinesSource", Frame(303, -2, {0, 0, 0}), 3010},
        BadFrame{"NaN", Frame(303, 0, {kNaN, 0, 0}), 3010},
        BadFrame{"Infinity", Frame(303, 0, {0, -kInfinity, 0}), 3010},
        BadFrame{"NaNAsAnAngle", FrameWith(&MotionArguments::rpy_des, {0, kNaN, 0}), 3010},
        BadFrame{"NaNAsAPosition", FrameWith(&MotionArguments::pos_des, {0, 0, kNaN}), 3010},
        BadFrame{"AnInfiniteStepHeight",
                 FrameWith(&MotionArguments::step_height, {kInfinity, 0.05F}), 3010},
        BadFrame{"TwoSpeeds", Frame(303, 0, {0.1F, 0}), 3010},
        BadFrame{"FourSpeeds", Frame(303, 0, {0.1F, 0, 0, 0}), 3010},
        BadFrame{"UnknownType", Frame(303, 0, {0.1F, 0, 0}, 3), 3010},
        BadFrame{"EndOfUnknownSource", Frame(303, 17, {}, 2), 3010}),
    [](const auto& param) { return param.param.name; });

TEST(MotionServo, IsLimitedToTheSpeedOfItsGaitAndLogsItOnce) {
  Harness harness;
  for (int i = 0; i < 20; ++i) {
    harness.Servo(303, 0, {9, -9, 9});
    harness.RunFor(Milliseconds(50));
  }
  EXPECT_EQ(harness.sent.back().command.vel, (std::array<float, 3>{0.65F, -0.30F, 1.25F}));
  EXPECT_EQ(harness.LogLines(), 1U);
}

// A board is given no posture that its legs do not have: what it does with one is not documented.
TEST(MotionServo, IsLimitedToTheAnglesAndHeightsOfTheBoardAndLogsThem) {
  Harness harness;
  ServoCommand command = Frame(303, 0, {0.1F, 0, 0});
  command.requested.arguments.rpy_des = {1, -1, 0.2F};
  command.requested.arguments.pos_des = {0.01F, 0, 0.5F};
  command.requested.arguments.step_height = {0.3F, -0.1F};
  harness.Do(motion_event::ServoArrived{command});
  const BodyCommand& sent = harness.sent.back().command;
  EXPECT_EQ(sent.rpy, (std::array<float, 3>{0.45F, -0.45F, 0.2F}));
  EXPECT_EQ(sent.pos, (std::array<float, 3>{0.01F, 0, 0.32F}));
  EXPECT_EQ(sent.step_height, (std::array<float, 2>{0.06F, 0}));
  EXPECT_THAT(harness.log, ElementsAre("servo motion 303 of App is limited to its ranges: rpy_des, "
                                       "pos_des, step_height"));
}

TEST(MotionServo, OfTheLowestBodyIsNoLowerThanTheBoardsAndZeroIsItsOwnHeight) {
  for (const auto& [id, height_m, sent_m] :
       {std::tuple{303, 0.05F, 0.1F}, std::tuple{303, -0.2F, 0.1F}, std::tuple{303, 0.0F, 0.0F},
        std::tuple{kForceControl, 0.05F, 0.1F}, std::tuple{202, -0.02F, -0.02F}}) {
    Harness harness;
    ServoCommand command = Frame(id, 0, {0, 0, 0});
    command.requested.arguments.pos_des = {0, 0, height_m};
    harness.Do(motion_event::ServoArrived{command});
    EXPECT_EQ(harness.sent.back().command.pos[2], sent_m) << id << " with " << height_m;
  }
}

TEST(MotionServo, IsRefusedWith3035WhenTheBoardIsSilent) {
  Harness harness;
  harness.board.silent = true;
  harness.RunFor(Milliseconds(600));
  harness.Servo(303);
  EXPECT_EQ(harness.ServoCode(), 3035);
  EXPECT_THAT(harness.sent, IsEmpty());
}

TEST(MotionServo, DoesNotTreatABoardAsSilentWhoseReportsAreQueued) {
  Harness harness;
  harness.StandStill(Milliseconds(700));
  harness.Servo(303);
  EXPECT_EQ(harness.ServoCode(), kCodeOk) << "its frame is read before the reports";
  harness.Stream(303, Milliseconds(200));
  EXPECT_EQ(harness.ServoCode(), kCodeOk);
  harness.board.silent = true;
  harness.StandStill(Milliseconds(700));
  harness.Stream(303, Milliseconds(100));
  EXPECT_EQ(harness.ServoCode(), 3035) << "but this one was silent";
}

// Its frames were refused while the board was silent, so no servo motion was running.
TEST(MotionServo, WaitsForAPauseOfTheStreamAfterARestartOfTheBoard) {
  Harness harness;
  harness.board.silent = true;
  harness.RunFor(Milliseconds(700));
  harness.Stream(303, Milliseconds(3000));
  EXPECT_EQ(harness.ServoCode(), 3035);
  harness.Do(motion_event::BoardRestarted{});
  harness.board.silent = false;
  harness.RunFor(Milliseconds(100));
  harness.sent.clear();
  harness.Stream(303, Milliseconds(3000));
  EXPECT_THAT(harness.sent, IsEmpty());
  EXPECT_EQ(harness.ServoCode(), 3035);
  harness.RunFor(Milliseconds(250));
  harness.Servo(303);
  EXPECT_FALSE(harness.sent.empty()) << "a new stream";
}

TEST(MotionServo, EndsWhenTheBodyHasLainDownByItself) {
  Harness harness;
  harness.Stream(303, Milliseconds(1000));
  harness.board = Board();
  harness.Body(kGetDown);  // by the rule of the board: no frame for 500 ms
  harness.sent.clear();
  harness.Stream(303, Milliseconds(1000));
  EXPECT_THAT(harness.sent, IsEmpty()) << "neither a walk nor WALK_STAND";
  EXPECT_FALSE(harness.core.servo);
  EXPECT_EQ(harness.ServoCode(), 3035);
  EXPECT_THAT(harness.log, Contains(HasSubstr("is stopped: the body lies")));
  harness.RunFor(Milliseconds(250));
  harness.Stream(303, Milliseconds(2000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand, 303)) << "a new stream";
}

TEST(MotionServo, ContinuesAfterAReportOfABodyThatLiesWhichWasOnlyOld) {
  Harness harness;
  harness.Stream(303, Milliseconds(1000));
  BodyReport old = harness.board.report;
  old.mode = 7;
  old.gait = 1;
  harness.Do(motion_event::BoardReported{old});
  harness.Stream(303, Milliseconds(1000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303));
}

TEST(MotionServo, DoesNotStandALyingBodyUpWhenTheStreamChangesItsMotion) {
  Harness harness;
  harness.Stream(303, Milliseconds(1000));
  harness.board = Board();
  harness.Body(kGetDown);
  harness.sent.clear();
  harness.Stream(308, Milliseconds(1000));
  EXPECT_THAT(harness.sent, IsEmpty());
  EXPECT_FALSE(harness.core.servo);
  EXPECT_EQ(harness.ServoCode(), 3035);
}

TEST(MotionServo, ChangesItsMotionAfterAReportOfABodyThatLiesWhichWasOnlyOld) {
  Harness harness;
  harness.Stream(303, Milliseconds(1000));
  BodyReport old = harness.board.report;
  old.mode = 7;
  old.gait = 1;
  harness.Do(motion_event::BoardReported{old});
  harness.Stream(308, Milliseconds(1000));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, 308));
}

TEST(MotionServo, PublishesTheBoardsFeedbackPeriodically) {
  Harness harness;
  harness.Stream(303, Milliseconds(1000));
  const std::size_t before = harness.responses.size();
  harness.Stream(303, Milliseconds(1000));
  EXPECT_NEAR(static_cast<double>(harness.responses.size() - before), 20, 2);
  EXPECT_EQ(harness.responses.back().motion_id, 303);
  EXPECT_EQ(harness.responses.back().bar, 100);
  EXPECT_TRUE(harness.responses.back().result);
}

TEST(MotionServo, ReportsThatTheBoardFellSilent) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.board.silent = true;
  harness.Stream(303, Milliseconds(1000));
  const motion_action::ServoResponse expected{-1,  harness.responses.back().cmd_id, -1, -1, false,
                                              3035};
  EXPECT_EQ(harness.responses.back(), expected);
}

TEST(MotionServo, ReportsTheBoardsErrorAsItsCode) {
  Harness harness;
  harness.board.fault = 4;
  harness.Stream(303, Milliseconds(500));
  EXPECT_EQ(harness.ServoCode(), 3024);
  EXPECT_FALSE(harness.responses.back().result);
}

// A board goes on with the walk that it has.
TEST(MotionServo, DoesNotWalkOnWhenALiftedBodyIsPutDown) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.board.fault = 4;
  harness.Stream(303, Milliseconds(500));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, kWalkStand));
  harness.board.fault = 0;
  harness.Stream(303, Milliseconds(500));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, kWalkStand)) << "the stream has not paused";
  EXPECT_EQ(harness.ServoCode(), 3024);
  harness.RunFor(Milliseconds(300));
  harness.Stream(303, Milliseconds(500));
  EXPECT_EQ(harness.Commanded().back(), 303);
}

// The same count would keep up the walk that the board could not end.
TEST(MotionServo, RenewsAStopThatTheBoardRefuses) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  harness.board.ban = true;
  const std::size_t before = harness.sent.size();
  harness.RunFor(Milliseconds(900));
  std::set<std::int8_t> counts;
  for (std::size_t i = before; i < harness.sent.size(); ++i) {
    if (harness.sent[i].command.id == kWalkStand) counts.insert(harness.sent[i].command.life_count);
  }
  EXPECT_GT(counts.size(), 10U);
  harness.board.ban = false;
  harness.RunFor(Milliseconds(300));
  EXPECT_EQ(harness.board.report.gait, TheTable().Find(kWalkStand)->gait);
}

// --- Control of the body

TEST(MotionPriority, LetsTheHigherOneTakeTheBodyFromTheLower) {
  Harness harness;
  harness.Stream(303, Milliseconds(200), kFromAlgorithm);
  harness.Servo(308, kFromApp);
  EXPECT_EQ(harness.core.servo->source, kFromApp);
  harness.RunFor(Milliseconds(50));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, 308));
}

TEST(MotionPriority, LetsTheHigherOneTakeTheBodyAtOnceFromAFastStreamOfTheLower) {
  Harness harness;
  harness.Stream(303, Milliseconds(200), kFromAlgorithm);
  for (int i = 0; i < 100; ++i) {
    harness.Servo(303, kFromAlgorithm, {0.2F + 0.001F * static_cast<float>(i), 0, 0});
    harness.RunFor(std::chrono::microseconds(250));
  }
  harness.Servo(305, kFromApp, {0, 0, 0});
  EXPECT_EQ(harness.core.servo->command.id, 305);
  harness.RunFor(Milliseconds(2));
  EXPECT_EQ(harness.sent.back().command.id, 305);
}

// In the original `result` kept the value of the command before.
TEST(MotionPriority, RefusesTheLowerOneWith3001) {
  Harness harness;
  harness.Stream(303, Milliseconds(200), kFromApp);
  harness.Servo(308, kFromAudio);
  EXPECT_EQ(harness.ServoCode(), 3001);
  EXPECT_FALSE(harness.responses.back().result);
  harness.RunFor(Milliseconds(50));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303));
}

TEST(MotionPriority, DoesNotLetTheLowerOneStopTheHigher) {
  Harness harness;
  harness.Stream(303, Milliseconds(200), kFromApp);
  harness.Servo(303, kFromAlgorithm, {}, ServoCommand::kEnd);
  EXPECT_EQ(harness.ServoCode(), 3001);
  EXPECT_TRUE(harness.core.servo);
}

TEST(MotionPriority, LetsTheHigherOneStopTheLower) {
  Harness harness;
  harness.Stream(303, Milliseconds(200), kFromAlgorithm);
  harness.Servo(303, kFromDebug, {}, ServoCommand::kEnd);
  EXPECT_FALSE(harness.core.servo);
  EXPECT_EQ(harness.sent.back().command.id, kWalkStand);
}

TEST(MotionPriority, IsFreeAgainWhenTheStreamEnded) {
  Harness harness;
  harness.Stream(303, Milliseconds(200), kFromApp);
  harness.RunFor(Milliseconds(200));
  harness.Servo(303, kFromAlgorithm);
  EXPECT_EQ(harness.core.servo->source, kFromAlgorithm);
}

// A refused frame must not reset the watchdog of the other source.
TEST(MotionPriority, FramesOfARefusedOneDoNotKeepTheBodyMoving) {
  Harness harness;
  harness.Servo(303, kFromApp);
  for (int i = 0; i < 4; ++i) {
    harness.RunFor(Milliseconds(50));
    if (harness.core.servo) harness.Servo(303, kFromAlgorithm);
  }
  EXPECT_EQ(harness.sent.back().command.id, kWalkStand);
}

TEST(MotionPriority, IsConfigurable) {
  Harness harness;
  harness.config.priorities[kFromAlgorithm] = -5;
  harness.Stream(303, Milliseconds(200), kFromApp);
  harness.Servo(303, kFromAlgorithm);
  EXPECT_EQ(harness.core.servo->source, kFromAlgorithm);
}

}  // namespace musher::motion::testing::motion_servo_test
