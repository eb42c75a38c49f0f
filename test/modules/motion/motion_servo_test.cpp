// Servo commands: who has the body, the watchdog, what the streamer is told.

#include <gmock/gmock.h>

#include <limits>

#include "musher/test/modules/motion/stage.hpp"

namespace musher::motion::testing::motion_servo_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::array<float, 3> kStill{};

TEST(MotionServo, MovesTheBodyAsLongAsFramesCome) {
  Stage stage;
  stage.Stream(303, Milliseconds(2000));
  EXPECT_THAT(stage.Commanded(), ElementsAre(303));
  EXPECT_EQ(stage.ServoCode(), kCodeOk);
  EXPECT_EQ(stage.sent.back().command.vel, (std::array<float, 3>{0.2F, 0, 0}));
}

TEST(MotionServo, ReachesTheBoardWithItsFirstFrame) {
  Stage stage;
  stage.Servo(303);
  ASSERT_EQ(stage.sent.size(), 1U);
  EXPECT_EQ(stage.sent[0].at, stage.now);
}

TEST(MotionServo, ReachesTheBoardAt20HzHoweverFastFramesCome) {
  Stage stage;
  const Time begin = stage.now;
  for (int i = 0; i < 500; ++i) {
    stage.Servo(303, 0, {0.001F * static_cast<float>(i), 0, 0});
    stage.RunFor(Milliseconds(2));
  }
  EXPECT_EQ(stage.now - begin, Milliseconds(1000));
  EXPECT_NEAR(static_cast<double>(stage.sent.size()), 20, 1);
  EXPECT_GT(stage.sent.back().command.vel[0], 0.46F) << "the newest frame counts";
}

TEST(MotionServo, TakesFramesOfTypeStartLikeData) {
  Stage stage;
  stage.Servo(303, 0, {0.2F, 0, 0}, ServoCommand::kStart);
  EXPECT_THAT(stage.Commanded(), ElementsAre(303));
}

TEST(MotionServo, StopsTheBodyAfterEnd) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.Servo(303, 0, {}, ServoCommand::kEnd);
  EXPECT_EQ(stage.sent.back().at, stage.now);
  EXPECT_EQ(stage.sent.back().command.id, kWalkStand);
  EXPECT_EQ(stage.sent.back().command.vel, kStill);
  EXPECT_TRUE(stage.core.Idle());
  EXPECT_EQ(stage.ServoCode(), kCodeOk);
}

TEST(MotionServo, StopsTheBody200msAfterTheLastFrame) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.Servo(303);
  const Time last = stage.now;
  stage.RunFor(Milliseconds(199));
  EXPECT_EQ(stage.sent.back().command.id, 303);
  stage.RunFor(Milliseconds(1));
  EXPECT_EQ(stage.sent.back().command.id, kWalkStand);
  EXPECT_EQ(stage.sent.back().at, last + Milliseconds(200));
  EXPECT_TRUE(stage.core.Idle()) << "whoever comes next gets the body";
  EXPECT_THAT(stage.log, Contains(HasSubstr("no frame for 200 ms")));
}

// A program that stood still heard nothing meanwhile; that is no fault of the stream.
TEST(MotionServo, GoesOnWhenItsFramesOnlyWaitedToBeRead) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.StandStill(Milliseconds(700));
  stage.Stream(303, Milliseconds(500));
  EXPECT_THAT(stage.Commanded(), ElementsAre(303));
  EXPECT_THAT(stage.log, IsEmpty());
  EXPECT_EQ(stage.ServoCode(), kCodeOk);
}

TEST(MotionServo, IsStoppedAtTheSecondLookWhenNoFrameHadWaited) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.StandStill(Milliseconds(700));
  EXPECT_TRUE(stage.core.servo);
  stage.StandStill(Milliseconds(700));
  EXPECT_EQ(stage.sent.back().command.id, kWalkStand) << "however late that is";
  EXPECT_TRUE(stage.core.Idle());
}

TEST(MotionServo, IsStoppedWithItsLastValueAndStepHeight) {
  Stage stage;
  ServoCommand command;
  command.order.id = 303;
  command.order.arguments.vel_des = {0.3F, 0, 0};
  command.order.arguments.step_height = {0.06F, 0.07F};
  command.order.arguments.value = 2;
  stage.Do(motion_event::ServoArrived{command});
  stage.RunFor(Milliseconds(300));
  EXPECT_EQ(stage.sent.back().command.id, kWalkStand);
  EXPECT_EQ(stage.sent.back().command.value, 2);
  EXPECT_EQ(stage.sent.back().command.step_height, (std::array<float, 2>{0.06F, 0.07F}));
}

TEST(MotionServo, OfForceControl201EndsWithoutWalkStand) {
  Stage stage;
  stage.Stream(201, Milliseconds(300));
  stage.RunFor(Milliseconds(1000));
  EXPECT_THAT(stage.Commanded(), ElementsAre(201));
  EXPECT_TRUE(stage.core.Idle());
}

TEST(MotionServo, RepeatsItsStopUntilTheBoardTakesItButNotForEver) {
  Stage stage;
  stage.Stream(303, Milliseconds(300));
  stage.board.deaf = true;
  stage.Servo(303, 0, {}, ServoCommand::kEnd);
  const std::size_t before = stage.sent.size();
  stage.RunFor(Milliseconds(3000));
  EXPECT_NEAR(static_cast<double>(stage.sent.size() - before), 20, 1);
  Stage hearing;
  hearing.Stream(303, Milliseconds(300));
  hearing.Servo(303, 0, {}, ServoCommand::kEnd);
  const std::size_t then = hearing.sent.size();
  hearing.RunFor(Milliseconds(3000));
  EXPECT_LE(hearing.sent.size(), then + 1);
}

TEST(MotionServo, GoesThroughRecoveryStandWhereTheBodyLies) {
  Stage stage;
  stage.Body(kGetDown);
  stage.Stream(303, Milliseconds(2000));
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand, 303));
}

TEST(MotionServo, DoesNotBeginWhenTheStreamEndsDuringTheRecoveryStand) {
  Stage stage;
  stage.Body(kGetDown);
  stage.Servo(303);
  stage.RunFor(Milliseconds(2000));
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand));
  EXPECT_TRUE(stage.core.Idle());
}

// In the beginning its next frame was refused, and the streamer gave up.
TEST(MotionServo, ResumesAStreamThatStalledWhileTheBodyStandsUpForIt) {
  Stage stage;
  stage.Body(kGetDown);
  stage.Servo(303);
  stage.RunFor(Milliseconds(250));
  ASSERT_FALSE(stage.core.servo) << "the watchdog";
  ASSERT_TRUE(stage.core.job) << "it still stands up";
  stage.Servo(303, kFromDebug);
  EXPECT_EQ(stage.ServoCode(), 3011) << "to others the body is busy";
  stage.Servo(303);
  EXPECT_EQ(stage.ServoCode(), kCodeOk);
  EXPECT_TRUE(stage.core.servo && stage.core.job) << "and it waits again for the same stand";
  stage.Stream(303, Milliseconds(2000));
  EXPECT_EQ(stage.ServoCode(), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand, 303));
}

TEST(MotionServo, IsDroppedWhenTheRecoveryStandFails) {
  Stage stage;
  stage.Body(kGetDown);
  stage.board.fault = 10;  // stand stuck
  stage.Servo(303);
  stage.RunFor(Milliseconds(190));
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand));
  EXPECT_EQ(stage.ServoCode(), 3052);
  EXPECT_TRUE(stage.core.Idle());
}

TEST(MotionServo, OfAnotherGaitChangesOver) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.Stream(305, Milliseconds(500));
  EXPECT_THAT(stage.Commanded(), ElementsAre(303, 305));
}

TEST(MotionServo, WhileAResultCommandRunsIsRefusedWith3011) {
  Stage stage;
  const auto flip = stage.Ask(121);
  stage.RunFor(Milliseconds(100));
  stage.Servo(303);
  EXPECT_EQ(stage.ServoCode(), 3011);
  EXPECT_EQ(stage.CodeOf(flip), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(121));
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
  command.order.id = id;
  command.order.arguments.vel_des = std::move(vel);
  return command;
}

class BadServo : public ::testing::TestWithParam<BadFrame> {};

TEST_P(BadServo, IsRefusedWithItsCodeALogLineAndNothingMoves) {
  Stage stage;
  stage.Do(motion_event::ServoArrived{GetParam().command});
  EXPECT_EQ(stage.ServoCode(), GetParam().code);
  EXPECT_FALSE(stage.told.back().result) << "a refusal never says success";
  EXPECT_EQ(stage.LogLines(), 1U);
  stage.RunFor(Milliseconds(500));
  EXPECT_THAT(stage.sent, IsEmpty());
}

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

INSTANTIATE_TEST_SUITE_P(
    All, BadServo,
    ::testing::Values(BadFrame{"UnknownId", Frame(7777, 0, {0, 0, 0}), 3008},
                      BadFrame{"NegativeId", Frame(-1, 0, {0, 0, 0}), 3008},
                      BadFrame{"NoServoMotion", Frame(121, 0, {0, 0, 0}), 3008},
                      BadFrame{"EmergencyStopIsNoServoMotion", Frame(0, 0, {}), 3008},
                      BadFrame{"UnknownSource", Frame(303, 17, {0, 0, 0}), 3010},
                      BadFrame{"TheMachinesSource", Frame(303, -2, {0, 0, 0}), 3010},
                      BadFrame{"NaN", Frame(303, 0, {kNaN, 0, 0}), 3010},
                      BadFrame{"Infinity", Frame(303, 0, {0, -kInfinity, 0}), 3010},
                      BadFrame{"TwoSpeeds", Frame(303, 0, {0.1F, 0}), 3010},
                      BadFrame{"FourSpeeds", Frame(303, 0, {0.1F, 0, 0, 0}), 3010},
                      BadFrame{"UnknownType", Frame(303, 0, {0.1F, 0, 0}, 3), 3010},
                      BadFrame{"EndOfUnknownSource", Frame(303, 17, {}, 2), 3010}),
    [](const auto& param) { return param.param.name; });

TEST(MotionServo, IsSlowedDownToTheLimitsOfItsGaitAndSaysSoOnce) {
  Stage stage;
  for (int i = 0; i < 20; ++i) {
    stage.Servo(303, 0, {9, -9, 9});
    stage.RunFor(Milliseconds(50));
  }
  EXPECT_EQ(stage.sent.back().command.vel, (std::array<float, 3>{0.65F, -0.30F, 1.25F}));
  EXPECT_EQ(stage.LogLines(), 1U);
}

TEST(MotionServo, IsRefusedWith3035WhenTheBoardIsSilent) {
  Stage stage;
  stage.board.silent = true;
  stage.RunFor(Milliseconds(600));
  stage.Servo(303);
  EXPECT_EQ(stage.ServoCode(), 3035);
  EXPECT_THAT(stage.sent, IsEmpty());
}

TEST(MotionServo, TakesNoBoardForSilentWhoseReportsOnlyWaitToBeRead) {
  Stage stage;
  stage.StandStill(Milliseconds(700));
  stage.Servo(303);
  EXPECT_EQ(stage.ServoCode(), kCodeOk) << "its frame is read before the reports";
  stage.Stream(303, Milliseconds(200));
  EXPECT_EQ(stage.ServoCode(), kCodeOk);
  stage.board.silent = true;
  stage.StandStill(Milliseconds(700));
  stage.Stream(303, Milliseconds(100));
  EXPECT_EQ(stage.ServoCode(), 3035) << "but this one was silent";
}

TEST(MotionServo, TellsAllTheTimeWhatTheBoardMakesOfIt) {
  Stage stage;
  stage.Stream(303, Milliseconds(1000));
  const std::size_t before = stage.told.size();
  stage.Stream(303, Milliseconds(1000));
  EXPECT_NEAR(static_cast<double>(stage.told.size() - before), 20, 2);
  EXPECT_EQ(stage.told.back().motion_id, 303);
  EXPECT_EQ(stage.told.back().bar, 100);
  EXPECT_TRUE(stage.told.back().result);
}

TEST(MotionServo, TellsThatTheBoardFellSilent) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  stage.board.silent = true;
  stage.Stream(303, Milliseconds(1000));
  const motion_action::TellServo expected{-1, stage.told.back().cmd_id, -1, -1, false, 3035};
  EXPECT_EQ(stage.told.back(), expected);
}

TEST(MotionServo, TellsTheBoardsErrorAsItsCode) {
  Stage stage;
  stage.board.fault = 4;
  stage.Stream(303, Milliseconds(500));
  EXPECT_EQ(stage.ServoCode(), 3024);
  EXPECT_FALSE(stage.told.back().result);
}

// --- Who has the body

TEST(MotionPriority, LetsTheHigherOneTakeTheBodyFromTheLower) {
  Stage stage;
  stage.Stream(303, Milliseconds(200), kFromAlgorithm);
  stage.Servo(308, kFromApp);
  EXPECT_EQ(stage.core.servo->source, kFromApp);
  stage.RunFor(Milliseconds(50));
  EXPECT_THAT(stage.Commanded(), ElementsAre(303, 308));
}

// In the original `result` was left as the command before had it.
TEST(MotionPriority, RefusesTheLowerOneWith3001) {
  Stage stage;
  stage.Stream(303, Milliseconds(200), kFromApp);
  stage.Servo(308, kFromAudio);
  EXPECT_EQ(stage.ServoCode(), 3001);
  EXPECT_FALSE(stage.told.back().result);
  stage.RunFor(Milliseconds(50));
  EXPECT_THAT(stage.Commanded(), ElementsAre(303));
}

TEST(MotionPriority, DoesNotLetTheLowerOneStopTheHigher) {
  Stage stage;
  stage.Stream(303, Milliseconds(200), kFromApp);
  stage.Servo(303, kFromAlgorithm, {}, ServoCommand::kEnd);
  EXPECT_EQ(stage.ServoCode(), 3001);
  EXPECT_TRUE(stage.core.servo);
}

TEST(MotionPriority, LetsTheHigherOneStopTheLower) {
  Stage stage;
  stage.Stream(303, Milliseconds(200), kFromAlgorithm);
  stage.Servo(303, kFromDebug, {}, ServoCommand::kEnd);
  EXPECT_FALSE(stage.core.servo);
  EXPECT_EQ(stage.sent.back().command.id, kWalkStand);
}

TEST(MotionPriority, IsFreeAgainWhenTheStreamEnded) {
  Stage stage;
  stage.Stream(303, Milliseconds(200), kFromApp);
  stage.RunFor(Milliseconds(200));
  stage.Servo(303, kFromAlgorithm);
  EXPECT_EQ(stage.core.servo->source, kFromAlgorithm);
}

// A refused frame must not keep the watchdog of the other's quiet.
TEST(MotionPriority, FramesOfARefusedOneDoNotKeepTheBodyMoving) {
  Stage stage;
  stage.Servo(303, kFromApp);
  for (int i = 0; i < 4; ++i) {
    stage.RunFor(Milliseconds(50));
    if (stage.core.servo) stage.Servo(303, kFromAlgorithm);
  }
  EXPECT_EQ(stage.sent.back().command.id, kWalkStand);
}

TEST(MotionPriority, IsData) {
  Stage stage;
  stage.config.priorities[kFromAlgorithm] = -5;
  stage.Stream(303, Milliseconds(200), kFromApp);
  stage.Servo(303, kFromAlgorithm);
  EXPECT_EQ(stage.core.servo->source, kFromAlgorithm);
}

}  // namespace musher::motion::testing::motion_servo_test
