// Whole matches on a fake robot, and what the mission does with plans, failures and pauses.

#include <random>

#include "musher/test/modules/meilin/mission/match.hpp"

namespace musher::meilin::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using tree::Status;

MatchConfig MatchOf(const std::string& name) {
  const MatchReading reading = ReadMatchFile(ConfigFile(name));
  EXPECT_TRUE(reading.config) << ::testing::PrintToString(reading.errors);
  return reading.config.value_or(MatchConfig{});
}

// (0,1) -> fetch (1,1) from the front, climb there, fetch (2,1), ... to the exit.
std::vector<PlanStep> GoodPlan(Side side) {
  Grid grid;
  grid.side = side;
  std::vector<PlanStep> steps = {MoveStep(0, 1, 0)};
  for (int row = 1; row < kRows; ++row) {
    const double here_mm = grid.HeightMm({row - 1, 1});
    const double next_mm = grid.HeightMm({row, 1});
    if (row <= 3) {
      if (next_mm >= here_mm) {
        steps.push_back(FetchStep(row, 1, next_mm - here_mm));
        steps.push_back(MoveStep(row - 1, 1, here_mm));
      }
    }
    steps.push_back(MoveStep(row, 1, next_mm));
  }
  return steps;
}

// Servers that take realistic times; the partner is ready 3 s after the dock was extended.
void MakeRealistic(Match& match) {
  match.robot.fix = PoseFix{0.3, 0, 0, match.robot.Now()};
  match.robot.decide = [](const FakeGoal& goal) {
    Outcome outcome;
    const bool slow = goal.kind == Kind::kSuspension || goal.kind == Kind::kArm;
    outcome.after = Milliseconds(slow ? 3000 : 2000);
    return outcome;
  };
}
void ServePartner(Match& match) {
  for (const auto& goal : match.robot.goals) {
    if (goal->kind != Kind::kSpear || goal->spear.command != 3) continue;
    if (goal->state == GoalState::kSucceeded && match.robot.r1.value == false &&
        match.robot.Now() - goal->begun > Milliseconds(5000)) {
      FakeRobot::Raise(match.robot.r1, true);
    }
  }
}
void Play(Match& match, double seconds) {
  for (int i = 0; i < seconds * 100 && !match.rests; ++i) {
    match.Tick();
    ServePartner(match);
  }
}

class FullMatch : public ::testing::TestWithParam<Side> {};

TEST_P(FullMatch, IsPlayedToItsEnd) {
  const std::string side(SideText(GetParam()));
  Match match("full_match.xml", MatchOf("match_" + side + ".json"), GetParam());
  MakeRealistic(match);
  match.Tick();
  ASSERT_TRUE(match.Offer(GoodPlan(GetParam()))) << match.mission.last_error();
  Play(match, 400);
  EXPECT_EQ(match.last, Status::kSuccess) << match.mission.last_error();
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS");
  EXPECT_EQ(match.robot.Running(), 0U);
  const std::vector<std::string> texts = match.robot.Texts();
  EXPECT_EQ(texts.front(), "spear 1");
  EXPECT_THAT(texts, Contains("spear 4"));
  EXPECT_EQ(std::ranges::count(texts, "arm 1"), 3);
  EXPECT_THAT(texts, Contains("arm 5"));
  EXPECT_THAT(texts, Contains("arm 6"));
  EXPECT_EQ(texts.back(), "suspension direct 0 30");
}
INSTANTIATE_TEST_SUITE_P(Both, FullMatch, ::testing::Values(Side::kBlue, Side::kRed),
                         [](const auto& each) { return std::string(SideText(each.param)); });

TEST(MeilinMission, WaitsForAPlan) {
  Match match("meilin_stage.xml");
  match.RunFor(1);
  EXPECT_EQ(match.mission.state(), "WAITING_MF_ACTION_SEQ");
  EXPECT_TRUE(match.mission.WantsPlan());
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0)}));
  EXPECT_EQ(match.mission.state(), "MF_PLAN_READY");
  EXPECT_EQ(match.mission.plan_id(), "mf_action_seq_1");
  match.Run(10);
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS");
}
TEST(MeilinMission, ARefusedPlanIsNamedAndStands) {
  Match match("meilin_stage.xml");
  match.RunFor(0.1);
  EXPECT_FALSE(match.Offer({MoveStep(1, 1, 400)}));
  match.RunFor(1);
  EXPECT_EQ(match.mission.state(), "PLAN_REJECTED");
  EXPECT_THAT(match.mission.last_error(), StartsWith("move target_height mismatch"));
}
TEST(MeilinMission, ARefusedPlanLeavesTheRunningOne) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(1, 1, 200)}));
  match.RunFor(0.2);
  EXPECT_FALSE(match.Offer({MoveStep(9, 1, 0)}));
  match.Run(20);
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS");
  EXPECT_EQ(match.board->row.Get(), 1);
}
TEST(MeilinMission, RequestsNoPlanWhileOneRunsAndAnotherWasRefused) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0)}));
  match.RunFor(0.2);
  EXPECT_FALSE(match.Offer({MoveStep(9, 1, 0)}));
  EXPECT_EQ(match.mission.state(), "PLAN_REJECTED");
  EXPECT_FALSE(match.mission.WantsPlan());
}
TEST(MeilinMission, ASecondPlanReplacesTheQueueAfterTheRunningAction) {
  Match match("meilin_stage.xml");
  match.robot.fix = PoseFix{1.2, 1.2, 0, match.robot.Now()};
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(1, 1, 200)}));
  match.RunFor(0.2);
  ASSERT_TRUE(match.Offer({MoveStep(0, 2, 0)})) << match.mission.last_error();
  match.Run(20);
  EXPECT_THAT(match.robot.Texts(), ::testing::ElementsAre("move 1.20 2.40 0", "move 1.20 3.60 0"));
  EXPECT_EQ(match.mission.plan_id(), "mf_action_seq_2");
}
TEST(MeilinMission, AFailureStopsItUntilANewPlan) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal& goal) {
    return goal.kind == Kind::kSuspension ? Outcome{GoalState::kFailed, "Timeout"} : Outcome{};
  };
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(1, 1, 200), MoveStep(2, 1, 400)}));
  match.RunFor(20);
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_EQ(match.mission.last_error(), "Timeout");
  EXPECT_EQ(match.robot.goals.size(), 3U) << "nothing is sent after the failure";
  match.robot.decide = [](const FakeGoal&) { return Outcome{}; };
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  ASSERT_TRUE(match.Offer({MoveStep(1, 1, 200)})) << match.mission.last_error();
  match.Run(20);
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS");
}
TEST(MeilinMission, ResetBeginsAgainWithoutAPlan) {
  Match match("meilin_stage.xml");
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(1, 1, 200)}));
  match.RunFor(0.1);
  ASSERT_TRUE(match.mission.Command("RESET"));
  match.RunFor(1);
  EXPECT_EQ(match.mission.state(), "WAITING_MF_ACTION_SEQ");
  EXPECT_EQ(match.robot.Running(), 0U);
  EXPECT_FALSE(match.mission.Command("RESTE"));
}
TEST(MeilinMission, AfterAPauseTheHaltedSegmentIsTheNext) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(0, 2, 0)}));
  match.RunFor(0.2);
  match.Pause();
  EXPECT_EQ(match.robot.Running(), 0U);
  match.Run(20);
  EXPECT_THAT(match.robot.Texts(),
              ::testing::ElementsAre("move 1.20 2.40 0", "move 1.20 2.40 0", "move 1.20 3.60 0"));
}
TEST(MeilinMission, APauseDuringAClimbEndsIt) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(1, 0, 400)}));
  match.RunFor(0.2);
  match.Pause();
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_THAT(match.mission.last_error(), StartsWith("Move was halted during a climb"));
}
TEST(MeilinMission, APlanAfterAFailureInTheFieldDoesNotPrepareAgain) {
  Match match("full_match.xml", MatchOf("match_blue.json"));
  MakeRealistic(match);
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(1, 1, 200)}));
  for (int i = 0; i < 20000 && match.board->segment_index.Get() < 0; ++i) {
    match.Tick();
    ServePartner(match);
  }
  match.robot.decide = [](const FakeGoal&) { return Outcome{GoalState::kFailed, "broken"}; };
  Play(match, 60);
  ASSERT_EQ(match.mission.state(), "MISSION_FAILED");
  const std::size_t before = match.robot.goals.size();
  MakeRealistic(match);
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  ASSERT_TRUE(match.Offer({MoveStep(1, 1, 200)})) << match.mission.last_error();
  match.Tick();
  match.Tick();
  ASSERT_GT(match.robot.goals.size(), before);
  EXPECT_EQ(match.robot.goals[before]->Text(), "move 2.40 2.40 0");
}

Outcome RandomOutcome(std::mt19937& random) {
  const std::vector<Outcome> faults = {
      {GoalState::kUnavailable},  {GoalState::kRejected, "busy"}, {GoalState::kFailed, "broken"},
      {GoalState::kLost, "gone"}, {GoalState::kAccepted},         {GoalState::kCancelled}};
  Outcome outcome;
  if (random() % 12 == 0) outcome = faults[random() % faults.size()];
  outcome.after = Milliseconds(static_cast<std::int64_t>(random() % 3000));
  return outcome;
}

TEST(MeilinMission, MatchesWithRandomFaultsEndInANamedStateWithoutAGoal) {
  int won = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Side side = seed % 2 == 0 ? Side::kBlue : Side::kRed;
    Match match("full_match.xml", MatchOf("match_" + std::string(SideText(side)) + ".json"), side);
    MakeRealistic(match);
    match.robot.decide = [&random](const FakeGoal&) { return RandomOutcome(random); };
    ASSERT_TRUE(match.Offer(GoodPlan(side)));
    for (int i = 0; i < 60000 && !match.rests; ++i) {
      match.Tick();
      ServePartner(match);
      if (random() % 20000 == 0) match.Pause();
      if (random() % 5000 == 0) static_cast<void>(match.Offer({MoveStep(9, 9, 0)}));
    }
    ASSERT_TRUE(match.rests);
    const std::string state = match.mission.state();
    ASSERT_TRUE(state == "MISSION_SUCCESS" || state == "MISSION_FAILED") << state;
    ASSERT_EQ(state == "MISSION_FAILED", !match.mission.last_error().empty());
    ASSERT_EQ(match.robot.Running(), 0U);
    won += state == "MISSION_SUCCESS" ? 1 : 0;
  }
  EXPECT_GT(won, 0);
  EXPECT_LT(won, 300);
}

}  // namespace
}  // namespace musher::meilin::testing
