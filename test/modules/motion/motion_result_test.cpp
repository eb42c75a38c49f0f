// Result commands: which are taken, how a motion is executed to its end, and the code of each
// failure.

#include <gmock/gmock.h>

#include <limits>

#include "musher/test/modules/motion/harness.hpp"

namespace musher::motion::testing::motion_result_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

MotionArguments Duration(std::int32_t ms) {
  MotionArguments arguments;
  arguments.duration_ms = ms;
  return arguments;
}

TEST(MotionResult, IsAnsweredWhenTheBoardReportsItDone) {
  Harness harness;
  const auto token = harness.RequestMotion(121);
  EXPECT_THAT(harness.answers, IsEmpty()) << "the flip has not ended yet";
  EXPECT_EQ(harness.CodeOf(token), kCodeOk);
  EXPECT_EQ(harness.answers.at(token).motion_id, 121);
  EXPECT_THAT(harness.Commanded(), ElementsAre(121));
  EXPECT_TRUE(harness.core.Idle());
}

TEST(MotionResult, IsSentToTheBoardAtOnceAndRepeatedAt20Hz) {
  Harness harness;
  const Time requested_at = harness.now;
  const auto token = harness.RequestMotion(121);
  ASSERT_EQ(harness.CodeOf(token), kCodeOk);
  ASSERT_GE(harness.sent.size(), 8U);
  EXPECT_EQ(harness.sent[0].at, requested_at);
  EXPECT_EQ(harness.sent[1].at, requested_at + Milliseconds(50));
  const std::size_t frames = harness.sent.size();
  harness.RunFor(Milliseconds(1000));
  EXPECT_EQ(harness.sent.size(), frames) << "what has ended is not repeated";
}

TEST(MotionResult, OfAnUnknownIdIsRefusedWith3008) {
  Harness harness;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(7777)), 3008);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(-5)), 3008);
  EXPECT_THAT(harness.sent, IsEmpty());
  EXPECT_THAT(harness.log, Contains(HasSubstr("7777")));
}

// In the original an unknown source threw an exception.
TEST(MotionResult, OfAnUnknownSourceIsRefusedWith3010) {
  Harness harness;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121, 9)), 3010);
  EXPECT_THAT(harness.sent, IsEmpty());
  EXPECT_THAT(harness.log, Contains(HasSubstr("source 9")));
}

TEST(MotionResult, CannotUseTheSourceOfTheMachine) {
  Harness harness;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(101, kFromMachine)), 3006);
  EXPECT_THAT(harness.sent, IsEmpty());
}

struct DurationCase {
  std::int32_t id;
  std::int32_t duration_ms;
  std::int32_t code;
};

class MotionDuration : public ::testing::TestWithParam<DurationCase> {};

TEST_P(MotionDuration, FollowsTheTable) {
  Harness harness;
  const DurationCase& given = GetParam();
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(given.id, 0, Duration(given.duration_ms))),
            given.code);
  if (given.code != kCodeOk) {
    EXPECT_THAT(harness.sent, IsEmpty());
    EXPECT_EQ(harness.LogLines(), 1U);
  }
}

INSTANTIATE_TEST_SUITE_P(All, MotionDuration,
                         ::testing::Values(DurationCase{121, 0, 0}, DurationCase{121, 1000, 3010},
                                           DurationCase{121, -1, 3010}, DurationCase{212, 1000, 0},
                                           DurationCase{212, 0, 3010}, DurationCase{212, -7, 3010},
                                           DurationCase{303, 0, 0}, DurationCase{303, 1000, 0},
                                           DurationCase{303, -1000, 3010}),
                         [](const auto& param) {
                           const auto ms = param.param.duration_ms;
                           return std::to_string(param.param.id) + (ms < 0 ? "_minus_" : "_") +
                                  std::to_string(std::abs(ms)) + "ms";
                         });

TEST(MotionResult, WithNanIsRefusedWith3010) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    Harness harness;
    MotionArguments arguments;
    arguments.pos_des = {0, bad, 0};
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(111, 0, arguments)), 3010);
    EXPECT_THAT(harness.sent, IsEmpty());
    EXPECT_EQ(harness.LogLines(), 1U);
  }
}

TEST(MotionResult, UsesZerosForAnArrayOfAWrongLengthAndLogsIt) {
  Harness harness;
  MotionArguments arguments;
  arguments.vel_des = {0.3F, 0.1F};
  arguments.foot_pose = {1, 2, 3};
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(303, 0, arguments)), kCodeOk);
  EXPECT_EQ(harness.sent.front().command.vel, (std::array<float, 3>{}));
  EXPECT_EQ(harness.sent.front().command.foot_pose, (std::array<float, 6>{}));
  EXPECT_THAT(harness.log, Contains(HasSubstr("vel_des has 2 values instead of 3")));
}

TEST(MotionResult, WithContactZeroStandsOnAllFourFeet) {
  Harness harness;
  harness.RequestMotion(111);
  EXPECT_EQ(harness.sent.front().command.contact, 15);
  MotionArguments arguments;
  arguments.contact = 1000;
  Harness other;
  EXPECT_EQ(other.CodeOf(other.RequestMotion(111, 0, arguments)), 3010);
}

TEST(MotionResult, IsLimitedToTheSpeedOfTheMotion) {
  Harness harness;
  MotionArguments arguments;
  arguments.vel_des = {5, -5, 5};
  harness.RequestMotion(302, 0, arguments);
  EXPECT_EQ(harness.sent.front().command.vel, (std::array<float, 3>{0.25F, -0.10F, 0.50F}));
  EXPECT_THAT(harness.log,
              ElementsAre("motion 302 (JUMP_PRONK) is limited to its ranges: vel_des"));
}

TEST(MotionResult, IsLimitedToTheAnglesAndTheStepHeightOfTheBoard) {
  Harness harness;
  MotionArguments arguments;
  arguments.rpy_des = {0.5F, -0.5F, 0.45F};
  arguments.pos_des = {0.02F, 0, -0.05F};
  arguments.step_height = {0.09F, -0.01F};
  arguments.duration_ms = 500;
  harness.RequestMotion(212, 0, arguments);
  const BodyCommand& command = harness.sent.front().command;
  EXPECT_EQ(command.rpy, (std::array<float, 3>{0.45F, -0.45F, 0.45F}));
  EXPECT_EQ(command.pos, (std::array<float, 3>{0.02F, 0, -0.05F})) << "a relative height";
  EXPECT_EQ(command.step_height, (std::array<float, 2>{0.08F, 0}));
  EXPECT_THAT(
      harness.log,
      ElementsAre("motion 212 (POSECONTROL) is limited to its ranges: rpy_des, step_height"));
}

// Its heights of steps are two in one number: 30 and 50 mm are 50030.
TEST(MotionResult, OfAUsersGaitKeepsItsNumbers) {
  Harness harness;
  MotionArguments arguments;
  arguments.rpy_des = {0.5F, 0, 0};
  arguments.pos_des = {0, 0, 0.04F};
  arguments.step_height = {50030, 80000};
  harness.RequestMotion(401, 0, arguments);
  const BodyCommand& command = harness.sent.front().command;
  EXPECT_EQ(command.rpy, (std::array<float, 3>{0.5F, 0, 0}));
  EXPECT_EQ(command.pos, (std::array<float, 3>{0, 0, 0.04F}));
  EXPECT_EQ(command.step_height, (std::array<float, 2>{50030, 80000}));
  EXPECT_THAT(harness.log, IsEmpty());
}

TEST(MotionResult, WhileAnotherIsInProgressIsRefusedWith3011) {
  Harness harness;
  const auto first = harness.RequestMotion(121);
  harness.RunFor(Milliseconds(100));
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(111)), 3011);
  EXPECT_EQ(harness.CodeOf(first), kCodeOk) << "the first motion continues";
}

TEST(MotionResult, WhileServoCommandsMoveTheBodyIsRefusedWith3011) {
  Harness harness;
  harness.Stream(303, Milliseconds(500));
  const auto token = harness.RequestMotion(111, kFromDebug);
  ASSERT_EQ(harness.answers.count(token), 1U);
  EXPECT_EQ(harness.answers.at(token).code, 3011);
  EXPECT_TRUE(harness.core.servo);
}

TEST(MotionResult, OfGetDownInterruptsADance) {
  for (const std::int32_t dance : {140, 176, 177, 178}) {
    Harness harness;
    harness.board.motion = Milliseconds(60'000);
    const auto dancing = harness.RequestMotion(dance);
    harness.RunFor(Milliseconds(2000));
    harness.board.motion = Milliseconds(400);
    const auto down = harness.RequestMotion(kGetDown);
    EXPECT_EQ(harness.CodeOf(dancing), 3029);
    EXPECT_EQ(harness.CodeOf(down), kCodeOk);
    EXPECT_THAT(harness.Commanded(), ElementsAre(dance, kGetDown));
  }
}

TEST(MotionResult, OfGetDownDoesNotInterruptAFlip) {
  Harness harness;
  const auto flip = harness.RequestMotion(121);
  harness.RunFor(Milliseconds(200));
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kGetDown)), 3011);
  EXPECT_EQ(harness.CodeOf(flip), kCodeOk);
}

TEST(MotionResult, GoesThroughRecoveryStandWhereTheBodyMayNotGoThereDirectly) {
  Harness harness;
  harness.Body(kGetDown);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand, 121));
}

TEST(MotionResult, Of309ComesFromTheGroundStand118) {
  Harness harness;
  harness.Body(kGetDown);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(309)), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(118, 309, kWalkStand));
}

TEST(MotionResult, Of309StandsUpFirstWhereEven118IsOutOfReach) {
  Harness harness;
  harness.Body(212);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(309)), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand, 118, 309, kWalkStand));
}

TEST(MotionResult, FromAnUnknownMotionStandsUpFirst) {
  Harness harness;
  harness.board.report.mode = 99;
  harness.Do(motion_event::BoardReported{harness.board.report});
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(kRecoveryStand, 121));
}

TEST(MotionResult, FailsWith3035WhenTheBoardDoesNotTakeItWithin200ms) {
  Harness harness;
  harness.board.deaf = true;
  const Time requested_at = harness.now;
  const auto token = harness.RequestMotion(121);
  EXPECT_EQ(harness.CodeOf(token), 3035);
  EXPECT_EQ(harness.now, requested_at + Milliseconds(200));
}

TEST(MotionResult, IsRefusedWith3035WhenTheBoardIsSilent) {
  Harness harness;
  harness.board.silent = true;
  harness.RunFor(Milliseconds(600));
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3035);
  EXPECT_THAT(harness.sent, IsEmpty());
}

TEST(MotionResult, FailsWith3027WhenTheTransitionTakesMoreThan3s) {
  Harness harness;
  harness.board.transition = Milliseconds(60'000);
  const Time requested_at = harness.now;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3027);
  EXPECT_GE(harness.now, requested_at + Milliseconds(3000));
  EXPECT_LE(harness.now, requested_at + Milliseconds(3300));
}

struct TimeCase {
  std::int32_t id;
  std::int32_t duration_ms;
  std::int64_t time_ms;
};

class MotionExecution : public ::testing::TestWithParam<TimeCase> {};

TEST_P(MotionExecution, FailsWith3028AfterItsTime) {
  Harness harness;
  harness.board.stuck = true;
  const Time requested_at = harness.now;
  const auto token = harness.RequestMotion(GetParam().id, 0, Duration(GetParam().duration_ms));
  EXPECT_EQ(harness.CodeOf(token), 3028);
  // From taking the command to the motion the board needs 100 ms, and reports come every 20 ms.
  const auto took = harness.now - requested_at;
  EXPECT_GE(took, Milliseconds(GetParam().time_ms + 100));
  EXPECT_LE(took, Milliseconds(GetParam().time_ms + 160));
}

INSTANTIATE_TEST_SUITE_P(All, MotionExecution,
                         ::testing::Values(TimeCase{121, 0, 8000}, TimeCase{212, 1000, 1500},
                                           TimeCase{303, 0, 500}, TimeCase{303, 1000, 2000}),
                         [](const auto& param) {
                           return std::to_string(param.param.id) + "_for_" +
                                  std::to_string(param.param.duration_ms) + "ms";
                         });

struct StatusCase {
  int status;
  std::int32_t code;
};

class BoardStatus : public ::testing::TestWithParam<StatusCase> {};

TEST_P(BoardStatus, BecomesTheCodeOfTheMotion) {
  Harness harness;
  harness.board.fault = static_cast<std::int8_t>(GetParam().status);
  const auto token = harness.RequestMotion(121);
  EXPECT_EQ(harness.CodeOf(token), GetParam().code);
  EXPECT_NE(harness.answers.at(token).message, "");
}

INSTANTIATE_TEST_SUITE_P(
    All, BoardStatus,
    ::testing::Values(StatusCase{2, 3021}, StatusCase{3, 3023}, StatusCase{4, 3024},
                      StatusCase{5, 3022}, StatusCase{6, 3025}, StatusCase{7, 3026},
                      StatusCase{8, 3050}, StatusCase{9, 3051}, StatusCase{10, 3052},
                      StatusCase{11, 3053}, StatusCase{12, 3054}, StatusCase{13, 3055},
                      StatusCase{14, 3056}, StatusCase{15, 3029}, StatusCase{-1, 3029}),
    [](const auto& param) {
      return "gives" + std::to_string(param.param.code) + "_of_" +
             (param.param.status < 0 ? "minus1" : std::to_string(param.param.status));
    });

TEST(MotionResult, FailsWith3022WhenTheBoardBansTheTransition) {
  Harness harness;
  harness.board.ban = true;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3022);
}

// A board remembers the life count of the last command. A new motion manager that began with the
// same count would be taken for a heartbeat of the old one.
TEST(MotionResult, OfANewMotionManagerIsANewCommandForTheBoard) {
  for (int life = 0; life < 127; ++life) {
    Harness harness;
    harness.board.report.life_count = static_cast<std::int8_t>(life);
    harness.Do(motion_event::BoardReported{harness.board.report});
    harness.RequestMotion(121);
    EXPECT_NE(harness.sent.front().command.life_count, life);
    EXPECT_GT(harness.sent.front().command.life_count, 0);
  }
}

TEST(MotionResult, OfAWalkEndsStanding) {
  Harness harness;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(303, 0, Duration(1000))), kCodeOk);
  harness.RunFor(Milliseconds(500));
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, kWalkStand));
  EXPECT_EQ(harness.sent.back().command.vel, (std::array<float, 3>{}));
}

TEST(MotionResult, OfAWalkThatFailsEndsStanding) {
  Harness harness;
  harness.board.stuck = true;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(303, 0, Duration(1000))), 3028);
  EXPECT_THAT(harness.Commanded(), ElementsAre(303, kWalkStand));
}

TEST(MotionResult, OfSeveralMotionsRunsThemOneAfterTheOther) {
  Harness harness;
  EXPECT_EQ(harness.CodeOf(harness.Play({{130, {}}, {121, {}}, {101, {}}})), kCodeOk);
  EXPECT_THAT(harness.Commanded(), ElementsAre(130, kRecoveryStand, 121, 101));
}

TEST(MotionResult, OfSeveralMotionsIsRefusedWholeWhenOneIsWrong) {
  Harness harness;
  EXPECT_EQ(harness.CodeOf(harness.Play({{130, {}}, {7777, {}}})), 3008);
  EXPECT_EQ(harness.CodeOf(harness.Play({})), 3010);
  EXPECT_EQ(harness.CodeOf(harness.Play(std::vector<MotionRequest>(1001, {111, {}}))), 3010);
  EXPECT_THAT(harness.sent, IsEmpty());
}

TEST(MotionResult, LogsTheSameCodeOnceInThreeMinutes) {
  Harness harness;
  for (int i = 0; i < 100; ++i) harness.RequestMotion(7777);
  EXPECT_EQ(harness.LogLines(), 1U);
  harness.RunFor(std::chrono::seconds(180));
  harness.RequestMotion(7777);
  EXPECT_EQ(harness.LogLines(), 2U);
}

TEST(MotionResult, EndsWhenTheWorldIsRestarted) {
  Harness harness;
  const auto token = harness.RequestMotion(121);
  harness.now = Time(std::chrono::seconds(1));
  harness.Do(motion_event::WorldRestarted{});
  EXPECT_EQ(harness.CodeOf(token), 3035);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3035) << "nothing is known of the body yet";
}

// With two programs that publish /clock the board was "silent".
TEST(MotionResult, NamesWhyTheTimeHasJumped) {
  const std::string why = "2 programs publish /clock, and its time went back by 4.00 s";
  Harness harness;
  const auto token = harness.RequestMotion(121);
  harness.Do(motion_event::WorldRestarted{why});
  EXPECT_EQ(harness.answers.at(token).message, why);
  const auto next = harness.RequestMotion(121);
  EXPECT_EQ(harness.CodeOf(next), 3035);
  EXPECT_EQ(harness.answers.at(next).message, why);
}

// A board on LCM repeats the last command by itself.
TEST(MotionResult, OfAWalkIsStoppedWhenTheWorldIsRestarted) {
  for (const bool servo : {true, false}) {
    Harness harness;
    if (servo) {
      harness.Stream(303, Milliseconds(500));
    } else {
      MotionArguments arguments;
      arguments.vel_des = {0.2F, 0, 0};
      arguments.duration_ms = 5000;
      harness.RequestMotion(303, 0, arguments);
      harness.RunFor(Milliseconds(300));
    }
    ASSERT_EQ(harness.Commanded().back(), 303);
    harness.Do(motion_event::WorldRestarted{});
    EXPECT_EQ(harness.sent.back().command.id, kWalkStand) << servo;
  }
}

// The reports that came while the program was suspended are read one after the other.
TEST(MotionResult, DoesNotFailByAnOldReportInTheQueue) {
  Harness harness;
  const BodyReport before = harness.board.report;
  const auto flip = harness.RequestMotion(121);
  harness.StandStill(Milliseconds(300));
  harness.Do(motion_event::BoardReported{before});
  EXPECT_EQ(harness.CodeOf(flip), kCodeOk);
}

}  // namespace musher::motion::testing::motion_result_test
