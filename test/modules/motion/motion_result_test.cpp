// Result commands: what is taken, how a motion is brought to its end, and the code of each way in
// which it can go wrong.

#include <gmock/gmock.h>

#include <limits>

#include "musher/test/modules/motion/stage.hpp"

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

TEST(MotionResult, IsAnsweredWhenTheBoardSaysThatItIsDone) {
  Stage stage;
  const auto token = stage.Ask(121);
  EXPECT_THAT(stage.answers, IsEmpty()) << "the flip has not ended yet";
  EXPECT_EQ(stage.CodeOf(token), kCodeOk);
  EXPECT_EQ(stage.answers.at(token).motion_id, 121);
  EXPECT_THAT(stage.Commanded(), ElementsAre(121));
  EXPECT_TRUE(stage.core.Idle());
}

TEST(MotionResult, IsSentToTheBoardAtOnceAndRepeatedAt20Hz) {
  Stage stage;
  const Time asked = stage.now;
  const auto token = stage.Ask(121);
  ASSERT_EQ(stage.CodeOf(token), kCodeOk);
  ASSERT_GE(stage.sent.size(), 8U);
  EXPECT_EQ(stage.sent[0].at, asked);
  EXPECT_EQ(stage.sent[1].at, asked + Milliseconds(50));
  const std::size_t frames = stage.sent.size();
  stage.RunFor(Milliseconds(1000));
  EXPECT_EQ(stage.sent.size(), frames) << "what has ended is not repeated";
}

TEST(MotionResult, OfAnUnknownIdIsRefusedWith3008) {
  Stage stage;
  EXPECT_EQ(stage.CodeOf(stage.Ask(7777)), 3008);
  EXPECT_EQ(stage.CodeOf(stage.Ask(-5)), 3008);
  EXPECT_THAT(stage.sent, IsEmpty());
  EXPECT_THAT(stage.log, Contains(HasSubstr("7777")));
}

// In the original an unknown source threw an exception.
TEST(MotionResult, OfAnUnknownSourceIsRefusedWith3010) {
  Stage stage;
  EXPECT_EQ(stage.CodeOf(stage.Ask(121, 9)), 3010);
  EXPECT_THAT(stage.sent, IsEmpty());
  EXPECT_THAT(stage.log, Contains(HasSubstr("source 9")));
}

TEST(MotionResult, CannotBeGivenInTheNameOfTheMachine) {
  Stage stage;
  EXPECT_EQ(stage.CodeOf(stage.Ask(101, kFromMachine)), 3006);
  EXPECT_THAT(stage.sent, IsEmpty());
}

struct DurationCase {
  std::int32_t id;
  std::int32_t duration_ms;
  std::int32_t code;
};

class MotionDuration : public ::testing::TestWithParam<DurationCase> {};

TEST_P(MotionDuration, GoesByTheTable) {
  Stage stage;
  const DurationCase& given = GetParam();
  EXPECT_EQ(stage.CodeOf(stage.Ask(given.id, 0, Duration(given.duration_ms))), given.code);
  if (given.code != kCodeOk) {
    EXPECT_THAT(stage.sent, IsEmpty());
    EXPECT_EQ(stage.LogLines(), 1U);
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

TEST(MotionResult, WithANumberThatIsNoneIsRefusedWith3010) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    Stage stage;
    MotionArguments arguments;
    arguments.pos_des = {0, bad, 0};
    EXPECT_EQ(stage.CodeOf(stage.Ask(111, 0, arguments)), 3010);
    EXPECT_THAT(stage.sent, IsEmpty());
    EXPECT_EQ(stage.LogLines(), 1U);
  }
}

TEST(MotionResult, TakesZerosForAnArrayOfAWrongLengthAndSaysSo) {
  Stage stage;
  MotionArguments arguments;
  arguments.vel_des = {0.3F, 0.1F};
  arguments.foot_pose = {1, 2, 3};
  EXPECT_EQ(stage.CodeOf(stage.Ask(303, 0, arguments)), kCodeOk);
  EXPECT_EQ(stage.sent.front().command.vel, (std::array<float, 3>{}));
  EXPECT_EQ(stage.sent.front().command.foot_pose, (std::array<float, 6>{}));
  EXPECT_THAT(stage.log, Contains(HasSubstr("vel_des has 2 values instead of 3")));
}

TEST(MotionResult, WithContactZeroStandsOnAllFourFeet) {
  Stage stage;
  stage.Ask(111);
  EXPECT_EQ(stage.sent.front().command.contact, 15);
  MotionArguments arguments;
  arguments.contact = 1000;
  Stage other;
  EXPECT_EQ(other.CodeOf(other.Ask(111, 0, arguments)), 3010);
}

TEST(MotionResult, IsSlowedDownToTheLimitsOfTheMotion) {
  Stage stage;
  MotionArguments arguments;
  arguments.vel_des = {5, -5, 5};
  stage.Ask(302, 0, arguments);
  EXPECT_EQ(stage.sent.front().command.vel, (std::array<float, 3>{0.25F, -0.10F, 0.50F}));
  EXPECT_THAT(stage.log, Contains(HasSubstr("slowed down")));
}

TEST(MotionResult, WhileAnotherIsUnderWayIsRefusedWith3011) {
  Stage stage;
  const auto first = stage.Ask(121);
  stage.RunFor(Milliseconds(100));
  EXPECT_EQ(stage.CodeOf(stage.Ask(111)), 3011);
  EXPECT_EQ(stage.CodeOf(first), kCodeOk) << "the first one goes on";
}

TEST(MotionResult, WhileServoCommandsMoveTheBodyIsRefusedWith3011) {
  Stage stage;
  stage.Stream(303, Milliseconds(500));
  const auto token = stage.Ask(111, kFromDebug);
  ASSERT_EQ(stage.answers.count(token), 1U);
  EXPECT_EQ(stage.answers.at(token).code, 3011);
  EXPECT_TRUE(stage.core.servo);
}

TEST(MotionResult, OfGetDownInterruptsADance) {
  for (const std::int32_t dance : {140, 176, 177, 178}) {
    Stage stage;
    stage.board.motion = Milliseconds(60'000);
    const auto dancing = stage.Ask(dance);
    stage.RunFor(Milliseconds(2000));
    stage.board.motion = Milliseconds(400);
    const auto down = stage.Ask(kGetDown);
    EXPECT_EQ(stage.CodeOf(dancing), 3029);
    EXPECT_EQ(stage.CodeOf(down), kCodeOk);
    EXPECT_THAT(stage.Commanded(), ElementsAre(dance, kGetDown));
  }
}

TEST(MotionResult, OfGetDownDoesNotInterruptAFlip) {
  Stage stage;
  const auto flip = stage.Ask(121);
  stage.RunFor(Milliseconds(200));
  EXPECT_EQ(stage.CodeOf(stage.Ask(kGetDown)), 3011);
  EXPECT_EQ(stage.CodeOf(flip), kCodeOk);
}

TEST(MotionResult, GoesThroughRecoveryStandWhereTheBodyMayNotGoThereDirectly) {
  Stage stage;
  stage.Body(kGetDown);
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand, 121));
}

TEST(MotionResult, Of309ComesFromTheGroundStand118) {
  Stage stage;
  stage.Body(kGetDown);
  EXPECT_EQ(stage.CodeOf(stage.Ask(309)), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(118, 309, kWalkStand));
}

TEST(MotionResult, Of309StandsUpFirstWhereEven118IsOutOfReach) {
  Stage stage;
  stage.Body(212);
  EXPECT_EQ(stage.CodeOf(stage.Ask(309)), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand, 118, 309, kWalkStand));
}

TEST(MotionResult, FromAMotionThatNobodyKnowsStandsUpFirst) {
  Stage stage;
  stage.board.report.mode = 99;
  stage.Do(motion_event::BoardHeard{stage.board.report});
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(kRecoveryStand, 121));
}

TEST(MotionResult, FailsWith3035WhenTheBoardDoesNotTakeItWithin200ms) {
  Stage stage;
  stage.board.deaf = true;
  const Time asked = stage.now;
  const auto token = stage.Ask(121);
  EXPECT_EQ(stage.CodeOf(token), 3035);
  EXPECT_EQ(stage.now, asked + Milliseconds(200));
}

TEST(MotionResult, IsRefusedWith3035WhenTheBoardIsSilent) {
  Stage stage;
  stage.board.silent = true;
  stage.RunFor(Milliseconds(600));
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3035);
  EXPECT_THAT(stage.sent, IsEmpty());
}

TEST(MotionResult, FailsWith3027WhenTheTransitionTakesMoreThan3s) {
  Stage stage;
  stage.board.transition = Milliseconds(60'000);
  const Time asked = stage.now;
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3027);
  EXPECT_GE(stage.now, asked + Milliseconds(3000));
  EXPECT_LE(stage.now, asked + Milliseconds(3300));
}

struct TimeCase {
  std::int32_t id;
  std::int32_t duration_ms;
  std::int64_t time_ms;
};

class MotionExecution : public ::testing::TestWithParam<TimeCase> {};

TEST_P(MotionExecution, FailsWith3028AfterItsTime) {
  Stage stage;
  stage.board.stuck = true;
  const Time asked = stage.now;
  const auto token = stage.Ask(GetParam().id, 0, Duration(GetParam().duration_ms));
  EXPECT_EQ(stage.CodeOf(token), 3028);
  // From taking the command to the motion the board needs 100 ms, and reports come every 20 ms.
  const auto took = stage.now - asked;
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
  Stage stage;
  stage.board.fault = static_cast<std::int8_t>(GetParam().status);
  const auto token = stage.Ask(121);
  EXPECT_EQ(stage.CodeOf(token), GetParam().code);
  EXPECT_NE(stage.answers.at(token).message, "");
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
  Stage stage;
  stage.board.ban = true;
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3022);
}

// A board remembers the life count of the last command. A new motion manager that began with the
// same one was taken for the old one's sign of life.
TEST(MotionResult, OfANewMotionManagerIsANewCommandForTheBoard) {
  for (int life = 0; life < 127; ++life) {
    Stage stage;
    stage.board.report.life_count = static_cast<std::int8_t>(life);
    stage.Do(motion_event::BoardHeard{stage.board.report});
    stage.Ask(121);
    EXPECT_NE(stage.sent.front().command.life_count, life);
    EXPECT_GT(stage.sent.front().command.life_count, 0);
  }
}

TEST(MotionResult, OfAWalkEndsStanding) {
  Stage stage;
  EXPECT_EQ(stage.CodeOf(stage.Ask(303, 0, Duration(1000))), kCodeOk);
  stage.RunFor(Milliseconds(500));
  EXPECT_THAT(stage.Commanded(), ElementsAre(303, kWalkStand));
  EXPECT_EQ(stage.sent.back().command.vel, (std::array<float, 3>{}));
}

TEST(MotionResult, OfAWalkThatFailsEndsStanding) {
  Stage stage;
  stage.board.stuck = true;
  EXPECT_EQ(stage.CodeOf(stage.Ask(303, 0, Duration(1000))), 3028);
  EXPECT_THAT(stage.Commanded(), ElementsAre(303, kWalkStand));
}

TEST(MotionResult, OfSeveralMotionsRunsThemOneAfterTheOther) {
  Stage stage;
  EXPECT_EQ(stage.CodeOf(stage.Play({{130, {}}, {121, {}}, {101, {}}})), kCodeOk);
  EXPECT_THAT(stage.Commanded(), ElementsAre(130, kRecoveryStand, 121, 101));
}

TEST(MotionResult, OfSeveralMotionsIsRefusedWholeWhenOneIsWrong) {
  Stage stage;
  EXPECT_EQ(stage.CodeOf(stage.Play({{130, {}}, {7777, {}}})), 3008);
  EXPECT_EQ(stage.CodeOf(stage.Play({})), 3010);
  EXPECT_EQ(stage.CodeOf(stage.Play(std::vector<MotionOrder>(1001, {111, {}}))), 3010);
  EXPECT_THAT(stage.sent, IsEmpty());
}

TEST(MotionResult, TellsTheSameCodeInTheLogOnceInThreeMinutes) {
  Stage stage;
  for (int i = 0; i < 100; ++i) stage.Ask(7777);
  EXPECT_EQ(stage.LogLines(), 1U);
  stage.RunFor(std::chrono::seconds(180));
  stage.Ask(7777);
  EXPECT_EQ(stage.LogLines(), 2U);
}

TEST(MotionResult, EndsWhenTheWorldBeginsAnew) {
  Stage stage;
  const auto token = stage.Ask(121);
  stage.now = Time(std::chrono::seconds(1));
  stage.Do(motion_event::WorldRestarted{});
  EXPECT_EQ(stage.CodeOf(token), 3035);
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3035) << "nothing is known of the body yet";
}

// The reports that came while the program stood still are read one after the other.
TEST(MotionResult, DoesNotFailByTheOldestReportThatWaited) {
  Stage stage;
  const BodyReport before = stage.board.report;
  const auto flip = stage.Ask(121);
  stage.StandStill(Milliseconds(300));
  stage.Do(motion_event::BoardHeard{before});
  EXPECT_EQ(stage.CodeOf(flip), kCodeOk);
}

}  // namespace musher::motion::testing::motion_result_test
