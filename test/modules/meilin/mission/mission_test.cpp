// Whole matches on a fake robot, and what the mission does with plans, failures and pauses.

#include <algorithm>
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
  Match match("full_match.xml", MatchOf("simulated_" + side + ".json"), GetParam());
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
  EXPECT_EQ(match.mission.state(), "ACTION_RUNNING") << "what runs is not hidden";
  EXPECT_THAT(match.mission.refused_plan(), StartsWith("move grid out of range"));
  match.RunFor(0.3);
  EXPECT_THAT(match.mission.refused_plan(), StartsWith("move grid out of range"));
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
  EXPECT_THAT(match.mission.last_error(),
              StartsWith("segment 2 of 3, move (1, 1): suspension_control: Timeout after 0 s ("));
  EXPECT_EQ(match.robot.goals.size(), 3U) << "nothing is sent after the failure";
  match.robot.decide = [](const FakeGoal&) { return Outcome{}; };
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  ASSERT_TRUE(match.Offer({MoveStep(1, 1, 200)})) << match.mission.last_error();
  match.Run(20);
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS");
}
TEST(MeilinMission, ResetWaitsForItsStartWithoutAPlan) {
  Match match("meilin_stage.xml");
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(1, 1, 200)}));
  match.RunFor(0.1);
  match.Reset();
  match.RunFor(1);
  EXPECT_EQ(match.mission.state(), "WAITING_START");
  EXPECT_EQ(match.robot.Running(), 0U);
  const std::size_t goals = match.robot.goals.size();
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0)}));
  match.RunFor(1);
  EXPECT_EQ(match.robot.goals.size(), goals) << "a plan alone moves nothing";
  EXPECT_FALSE(match.mission.Command("RESTE"));
}
TEST(MeilinMission, ResetInAClimbMovesNothingAndDoesNotForgetTheEdge) {
  Match match("full_match.xml", MatchOf("match_blue.json"));
  match.Reset();
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(1, 1, 200)}));
  match.Begun("meilin");
  match.RunFor(0.2);
  match.Reset();
  const std::size_t goals = match.robot.goals.size();
  match.robot.fix = PoseFix{1.53, 2.4, 0, match.robot.Now()};
  match.robot.legs = Wheels{{205, 205, 205, 205}, match.robot.Now()};
  match.RunFor(2);
  EXPECT_EQ(match.robot.goals.size(), goals);
  EXPECT_EQ(match.robot.Running(), 0U);
  EXPECT_THAT(match.WhyNot("full"), HasSubstr("it comes off with the region meilin"));
  match.robot.fix.reset();
  EXPECT_THAT(match.WhyNot("full"), HasSubstr("a climb was not ended, and there is no fresh pose"));
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
  EXPECT_EQ(match.mission.state(), "PAUSED");
  match.Run(20);
  EXPECT_THAT(match.robot.Texts(),
              ::testing::ElementsAre("move 1.20 2.40 0", "move 1.20 2.40 0", "move 1.20 3.60 0"));
}
// The tree may be ticked before it takes the segment again, and what is saved then outlives a
// crash.
TEST(MeilinMission, AHaltedSegmentDoesNotCountAsDoneBeforeItIsTakenAgain) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(0, 2, 0)}));
  match.RunFor(0.2);
  match.Pause();
  match.mission.AfterTick(tree::Status::kRunning, "", match.robot.Now());
  EXPECT_EQ(match.mission.SavedProgress().next, 0);
  match.RunFor(1.2);
  match.Pause();
  match.mission.AfterTick(tree::Status::kRunning, "", match.robot.Now());
  EXPECT_EQ(match.mission.SavedProgress().next, 1) << "the first one is done";
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
  EXPECT_THAT(match.mission.last_error(),
              StartsWith("segment 1 of 1, move (1, 0): Move was halted during a climb"));
}
TEST(AMissionWhoseDebuggerIsLost, StandsAndGoesOnFromTheHaltedSegmentOnCommand) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(0, 2, 0)}));
  match.RunFor(0.2);
  match.LoseDebugger();
  EXPECT_EQ(match.mission.state(), "WAITING_START");
  match.RunFor(2);
  EXPECT_EQ(match.robot.Running(), 0U);
  EXPECT_EQ(match.mission.GoesOnWith(), "plan mf_action_seq_1 at segment 1 of 2, move (0, 1)");
  EXPECT_THAT(match.mission.CanStart(match.robot.Now()), Contains(""));
  match.Begun("").Run(20);
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS");
  EXPECT_THAT(match.robot.Texts(),
              ::testing::ElementsAre("move 1.20 2.40 0", "move 1.20 2.40 0", "move 1.20 3.60 0"));
}
TEST(AMissionWhoseDebuggerIsLost, DoesNotBeginWithANewPlanAfterAClimbThatWasHalted) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.Offer({MoveStep(1, 0, 400)}));
  match.RunFor(0.2);
  match.LoseDebugger();
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_FALSE(match.mission.WantsPlan()) << "a plan that is handed out once is not for it";
  const std::size_t goals = match.robot.goals.size();
  const auto report = [&match] {
    match.robot.fix = PoseFix{1.2, 1.2, 0, match.robot.Now()};
    match.robot.legs = Wheels{{20, 20, 20, 20}, match.robot.Now()};
  };
  report();
  EXPECT_TRUE(match.Offer({MoveStep(0, 1, 0)}));
  match.Follow();
  match.RunFor(0.5);
  EXPECT_EQ(match.robot.goals.size(), goals);
  report();
  match.Begun("").RunFor(0.5);
  EXPECT_EQ(match.robot.Texts().back(), "move 1.20 2.40 0");
}
TEST(AMissionWhoseDebuggerIsLost, RefusesAStartThatWaitsForThePose) {
  Match match(Match::Waiting{}, "meilin_stage.xml");
  std::string reply;
  match.mission.StartSoon("full", match.robot.Now(), [&reply](const Result<std::string>& begun) {
    reply = begun ? begun.value() : begun.error().message;
  });
  match.Tick();
  match.LoseDebugger();
  EXPECT_EQ(reply, "its debugger was lost before the match could begin");
  match.RunFor(3);
  EXPECT_FALSE(match.mission.begun());
}
TEST(AMissionWhoseDebuggerIsLost, DoesNotBeginByItselfWithItsFirstPose) {
  Match match(Match::Waiting{}, "full_match.xml", MatchOf("match_blue.json"), Side::kBlue, true);
  match.robot.fix.reset();
  match.RunFor(0.1);
  match.LoseDebugger();
  match.robot.fix = PoseFix{0.3, 0, 0, match.robot.Now()};
  match.RunFor(0.1);
  EXPECT_FALSE(match.mission.begun());
  EXPECT_TRUE(match.robot.goals.empty());
  const auto saved = ReadProgress(WriteProgress(match.mission.SavedProgress()), "saved");
  ASSERT_TRUE(saved);
  EXPECT_FALSE(saved.value().empty()) << "nor does the process that is started after its end";
  match.Begun("full");
  EXPECT_FALSE(match.mission.SavedProgress().stands);
}

TEST(AMissionWhoseDebuggerIsLost, WaitsForItsStartWithAPlanThatComesAfterTheEndOfTheOneBefore) {
  Match match("meilin_stage.xml");
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0)}));
  match.Run(20);
  ASSERT_EQ(match.mission.state(), "MISSION_SUCCESS");
  match.LoseDebugger();
  ASSERT_TRUE(match.Offer({MoveStep(0, 2, 0)}));
  match.RunFor(1);
  EXPECT_EQ(match.mission.state(), "WAITING_START");
  match.Begun("").Run(20);
  EXPECT_EQ(match.robot.Texts().back(), "move 1.20 3.60 0");
}
TEST(ARestartedMission, BeginsByItselfOnceAlsoWhereAPersonHasStartedAndResetIt) {
  Match match(Match::Waiting{}, "full_match.xml", MatchOf("match_blue.json"), Side::kBlue, true);
  match.robot.fix = PoseFix{1.2, 1.2, 0, match.robot.Now()};
  match.Begun("meilin").RunFor(0.1);
  match.robot.fix = PoseFix{0.3, 0, 0, match.robot.Now()};
  match.Reset();
  match.Tick();
  EXPECT_FALSE(match.mission.begun());
}
// As where a server ends its goal for an emergency stop before the mission knows of it.
TEST(MeilinMission, APauseOnTheWayOffAnEdgeAfterAFailedClimbEndsIt) {
  Match match("meilin_stage.xml");
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  match.robot.legs = Wheels{{20, 20, 20, 20}, match.robot.Now()};
  match.robot.decide = [](const FakeGoal& goal) {
    Outcome outcome{GoalState::kAccepted};
    if (goal.kind == Kind::kSuspension && goal.suspension.mode == 1) {
      outcome = {GoalState::kFailed, "Aborted: an emergency stop was engaged"};
    }
    return outcome;
  };
  ASSERT_TRUE(match.Offer({MoveStep(1, 1, 200)}));
  match.Tick();
  match.robot.fix = PoseFix{1.53, 2.4, 0, match.robot.Now()};
  match.robot.legs = Wheels{{205, 205, 205, 205}, match.robot.Now()};
  match.RunFor(0.5);
  ASSERT_EQ(match.mission.state(), "ACTION_RUNNING") << match.mission.last_error();
  ASSERT_EQ(match.board->active_action.Get(), "get_off_edge");
  match.Pause();
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_THAT(match.mission.last_error(),
              StartsWith("segment 1 of 1, move (1, 1): suspension_control: Aborted"));
  const std::size_t goals = match.robot.goals.size();
  match.RunFor(5);
  EXPECT_EQ(match.robot.goals.size(), goals);
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

// --- nothing moves without the word of a person ---

// The same mission in another process.
void Restart(const Match& before, Match& after) {
  const Result<Progress> progress =
      ReadProgress(WriteProgress(before.mission.SavedProgress()), "p.toml");
  ASSERT_TRUE(progress) << progress.error().message;
  EXPECT_EQ(progress.value(), before.mission.SavedProgress());
  ASSERT_TRUE(after.mission.Restore(progress.value()));
  after.robot.fix = before.robot.fix;
}

TEST(ARestartedMission, StandsAndSaysWithWhatItCanGoOn) {
  Match before("meilin_stage.xml");
  before.robot.fix = PoseFix{1.2, 1.2, 0, before.robot.Now()};
  ASSERT_TRUE(before.Offer({MoveStep(0, 1, 0), FetchStep(1, 1, 200), MoveStep(0, 1, 0)}, 7));
  for (int i = 0; i < 5000 && before.mission.SavedProgress().next < 2; ++i) before.Tick();
  Match after(Match::Waiting{}, "meilin_stage.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  after.RunFor(10);
  EXPECT_EQ(after.mission.state(), "WAITING_START");
  EXPECT_TRUE(after.robot.goals.empty());
  EXPECT_EQ(after.mission.GoesOnWith(), "plan mf_action_seq_1 at segment 3 of 3, move (0, 1)");
  EXPECT_TRUE(after.mission.WasTaken(7)) << "a latched plan comes again";
  EXPECT_FALSE(after.mission.WasTaken(8));
  after.Begun("");
  after.Run(20);
  EXPECT_THAT(
      after.robot.Texts(),
      ::testing::ElementsAre("move 1.20 2.40 0", "suspension direct 0 30", "move 1.20 2.40 0"));
  EXPECT_EQ(after.mission.state(), "MISSION_SUCCESS");
}
TEST(ARestartedMission, DoesNotGoOnWithARestThatDoesNotFitWhereTheRobotIs) {
  Match before("meilin_stage.xml");
  before.robot.fix = PoseFix{1.2, 2.4, 0, before.robot.Now()};
  before.robot.decide = [](const FakeGoal& goal) {
    return goal.kind == Kind::kMove && goal.move.x_m > 3
               ? Outcome{GoalState::kFailed, "XY phase timed out"}
               : Outcome{};
  };
  ASSERT_TRUE(before.Offer({MoveStep(1, 1, 200), MoveStep(2, 1, 400)}));
  before.Run(20);
  ASSERT_EQ(before.mission.state(), "MISSION_FAILED");
  Match after(Match::Waiting{}, "meilin_stage.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  after.robot.fix = PoseFix{1.2, 1.2, 0, after.robot.Now()};  // a person has put it there
  EXPECT_THAT(after.WhyNot(""), HasSubstr("does not fit where the robot is: move with height"));
  after.RunFor(1);
  EXPECT_TRUE(after.robot.goals.empty());
  EXPECT_EQ(after.WhyNot("meilin"), "") << "another plan may be sent";
  after.RunFor(1);
  EXPECT_EQ(after.mission.state(), "WAITING_MF_ACTION_SEQ");
}
TEST(ARestartedMission, DoesNotBeginWithThePreparationOnAPlatform) {
  Match match(Match::Waiting{}, "full_match.xml", MatchOf("match_blue.json"));
  match.robot.fix = PoseFix{2.4, 2.4, 0, match.robot.Now()};
  EXPECT_THAT(match.WhyNot("full"), HasSubstr("200 mm high: the way to x 0.50 m, y -0.20 m"));
  EXPECT_THAT(match.WhyNot("final"), HasSubstr("crosses"));
  EXPECT_THAT(match.mission.CanStart(match.robot.Now()), ::testing::ElementsAre("meilin"));
  match.RunFor(5);
  EXPECT_TRUE(match.robot.goals.empty());
  EXPECT_THAT(match.WhyNot("exit"), HasSubstr("expected full, meilin or final"));
}
TEST(ARestartedMission, BeginsByItselfOnlyWithThatOptionAndOutsideTheField) {
  for (const bool outside : {true, false}) {
    for (const bool autostart : {true, false}) {
      Match match(Match::Waiting{}, "full_match.xml", MatchOf("match_blue.json"), Side::kBlue,
                  autostart);
      match.robot.fix = PoseFix{outside ? 0.3 : 1.2, outside ? 0 : 1.2, 0, match.robot.Now()};
      match.RunFor(0.1);
      EXPECT_EQ(match.robot.goals.empty(), !(outside && autostart));
    }
  }
}
TEST(ARestartedMission, DoesNotBeginByItselfWhereThereIsSomethingToGoOnWith) {
  Match match(Match::Waiting{}, "full_match.xml", MatchOf("match_blue.json"), Side::kBlue, true);
  Progress progress;
  progress.done = {"prepare_spear_done"};
  ASSERT_TRUE(match.mission.Restore(progress));
  match.robot.fix = PoseFix{0.3, 0, 0, match.robot.Now()};
  match.RunFor(1);
  EXPECT_TRUE(match.robot.goals.empty());
  EXPECT_EQ(match.mission.GoesOnWith(), "the match before prepare_grasp");
  match.Begun("");
  match.Tick();
  EXPECT_THAT(match.robot.Texts(), ::testing::ElementsAre("spear 2"));
}
TEST(ARestartedMission, IgnoresADamagedProgressAndThatOfTheOtherSide) {
  EXPECT_FALSE(ReadProgress("next = 7\n", "p.toml"));
  EXPECT_FALSE(ReadProgress("plan = \"jump 1 1\"\n", "p.toml"));
  EXPECT_FALSE(ReadProgress("row = 99\n", "p.toml"));
  EXPECT_FALSE(ReadProgress("yaw_rad = nan\n", "p.toml"));
  EXPECT_FALSE(ReadProgress("plans = [", "p.toml"));
  EXPECT_FALSE(ReadProgress("wheels_mm = \"20 20 20\"\n", "p.toml"));
  EXPECT_FALSE(ReadProgress("wheels_mm = \"20 20 20 1e9\"\n", "p.toml"));
  EXPECT_TRUE(ReadProgress("", "p.toml"));
  Match match(Match::Waiting{}, "meilin_stage.xml");
  Progress red;
  red.side = "red";
  EXPECT_FALSE(match.mission.Restore(red));
  Progress old;
  old.segments = "{\"segments\": [{\"segment_type\": \"GRASP\"}]}";
  EXPECT_TRUE(match.mission.Restore(old));
  old.next = 2;
  EXPECT_FALSE(match.mission.Restore(old));
  old.segments = "{";
  EXPECT_FALSE(match.mission.Restore(old));
}
TEST(ARestartedMission, MovesNothingWhereItsWheelsWereOutAndDoNotReportAnyMore) {
  Match before("meilin_stage.xml");
  before.robot.fix = PoseFix{1.2, 1.2, 0, before.robot.Now()};
  before.robot.legs = Wheels{{20, 20, 20, 20}, before.robot.Now()};
  ASSERT_TRUE(before.Offer({FetchStep(1, 0, 400), MoveStep(0, 0, 0)}));
  for (int i = 0; i < 5000 && before.mission.SavedProgress().next < 1; ++i) before.Tick();
  EXPECT_THAT(before.mission.SavedProgress().wheels_mm, ::testing::Each(430));
  Match after(Match::Waiting{}, "meilin_stage.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  const std::string last = "the wheels do not report, and the last that they reported is 430, 430";
  for (const char* region : {"", "full", "meilin"}) {
    EXPECT_THAT(after.WhyNot(region), StartsWith(last)) << region;
  }
  EXPECT_TRUE(after.mission.CanStart(after.robot.Now()).empty());
  after.robot.legs = Wheels{{30, 30, 30, 30}, after.robot.Now()};
  after.RunFor(0.1);
  after.Begun("");
}
TEST(ARestartedMission, CarriesOutThePlanThatWaitedForItsStart) {
  Match before(Match::Waiting{}, "meilin_stage.xml");
  before.robot.fix = PoseFix{1.2, 1.2, 0, before.robot.Now()};
  ASSERT_TRUE(before.Offer({MoveStep(0, 1, 0)}, 7));
  Match after(Match::Waiting{}, "meilin_stage.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  EXPECT_TRUE(after.mission.WasTaken(7)) << "it does not come again";
  after.Begun("meilin").Run(20);
  EXPECT_EQ(after.mission.state(), "MISSION_SUCCESS");
  EXPECT_THAT(after.robot.Texts(), ::testing::ElementsAre("move 1.20 2.40 0"));
}
TEST(ARestartedMission, DoesNotCarryOutAPlanThatWasBegunWhereAnotherOneIsWanted) {
  Match before("meilin_stage.xml");
  before.robot.fix = PoseFix{1.2, 1.2, 0, before.robot.Now()};
  before.robot.decide = [](const FakeGoal&) { return Outcome{GoalState::kAccepted}; };
  ASSERT_TRUE(before.Offer({MoveStep(0, 1, 0)}));
  before.RunFor(1);
  Match after(Match::Waiting{}, "meilin_stage.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  after.Begun("meilin").RunFor(2);
  EXPECT_EQ(after.mission.state(), "WAITING_MF_ACTION_SEQ");
  EXPECT_TRUE(after.robot.goals.empty());
}
TEST(ARestartedMission, BeginsAPlanThatCameInTheMiddleOfAnotherOneAtItsFirstSegment) {
  Match before("meilin_stage.xml");
  before.robot.fix = PoseFix{1.2, 1.2, 0, before.robot.Now()};
  before.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(before.Offer({MoveStep(0, 1, 0), MoveStep(0, 2, 0), MoveStep(0, 1, 0)}));
  for (int i = 0; i < 5000 && before.mission.SavedProgress().next < 2; ++i) before.Tick();
  before.RunFor(0.1);
  ASSERT_TRUE(before.Offer({MoveStep(0, 2, 0), MoveStep(0, 1, 0)}))
      << before.mission.refused_plan();
  before.RunFor(0.1);
  Match after(Match::Waiting{}, "meilin_stage.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  EXPECT_EQ(after.mission.GoesOnWith(), "plan mf_action_seq_2 at segment 1 of 2, move (0, 2)");
}
TEST(ARestartedMission, DoesNotGoOnWithAPlanThatAnotherTreeHasRun) {
  Match sequences("meilin_stage.xml");
  sequences.robot.fix = PoseFix{1.2, 1.2, 0, sequences.robot.Now()};
  sequences.robot.decide = [](const FakeGoal&) { return Outcome{GoalState::kAccepted}; };
  ASSERT_TRUE(sequences.Offer({MoveStep(0, 1, 0)}, 7));
  sequences.RunFor(1);
  Match segments(Match::Waiting{}, "segments.xml");
  ASSERT_TRUE(segments.mission.Restore(sequences.mission.SavedProgress()));
  EXPECT_EQ(segments.mission.GoesOnWith(), "");
  EXPECT_TRUE(segments.mission.WasTaken(7));
  EXPECT_THAT(segments.WhyNot(""), HasSubstr("there is nothing to go on with"));
  Match old("segments.xml");
  old.robot.fix = PoseFix{1.2, 1.2, 0, old.robot.Now()};
  old.robot.decide = sequences.robot.decide;
  ASSERT_TRUE(old.OfferOld(R"({"segment_type": "GRASP"})"));
  old.RunFor(1);
  Match stage(Match::Waiting{}, "meilin_stage.xml");
  ASSERT_TRUE(stage.mission.Restore(old.mission.SavedProgress()));
  EXPECT_EQ(stage.mission.GoesOnWith(), "");
}
TEST(ARestartedMission, SaysThatThePlanThatWaitedForItsStartDoesNotFitAnyMore) {
  Match match(Match::Waiting{}, "meilin_stage.xml");
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  ASSERT_TRUE(match.Offer({MoveStep(1, 1, 200)}));
  match.robot.fix = PoseFix{1.2, 1.2, 0, match.robot.Now()};  // a person has put it there
  match.Begun("meilin").Run(5);
  EXPECT_EQ(match.mission.state(), "WAITING_MF_ACTION_SEQ");
  EXPECT_THAT(match.mission.refused_plan(),
              StartsWith("plan mf_action_seq_1 does not fit where the robot is: "));
  EXPECT_TRUE(match.robot.goals.empty());
}

// --- plans that a service hands out ---

TEST(APlanThatAServiceHandsOut, IsNotTakenAgainUntilTheServiceHasSaidThatItHasNone) {
  Match before("meilin_stage.xml");
  const auto plan = ToActionSequence({MoveStep(0, 1, 0), MoveStep(0, 2, 0)});
  before.robot.decide = [](const FakeGoal&) { return Outcome{GoalState::kFailed, "broken"}; };
  ASSERT_TRUE(before.mission.OfferHandedOut(plan, before.robot.Now()));
  before.Run(20);
  ASSERT_EQ(before.mission.state(), "MISSION_FAILED");
  EXPECT_FALSE(before.mission.WantsPlan()) << "it stands until a person goes on";
  EXPECT_FALSE(before.mission.OfferHandedOut(plan, before.robot.Now()));
  EXPECT_EQ(before.mission.state(), "MISSION_FAILED") << "the robot stands";
  Match after(Match::Waiting{}, "meilin_stage.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  after.Begun("meilin");
  EXPECT_FALSE(after.mission.OfferHandedOut(plan, after.robot.Now()));
  after.RunFor(1);
  EXPECT_TRUE(after.robot.goals.empty());
  after.mission.NothingHandedOut();
  EXPECT_TRUE(after.mission.OfferHandedOut(plan, after.robot.Now())) << "it was sent once more";
}
// The planner publishes the plan that its buffer hands out: a match that had failed began again.
TEST(APlanThatAServiceHandsOut, IsNotTakenAgainWhereItsTopicHasBroughtIt) {
  Match match("meilin_stage.xml");
  match.robot.decide = [](const FakeGoal&) { return Outcome{GoalState::kFailed, "broken"}; };
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0)}, 7));
  match.Run(20);
  ASSERT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_FALSE(match.mission.WantsPlan());
  EXPECT_FALSE(
      match.mission.OfferHandedOut(ToActionSequence({MoveStep(0, 1, 0)}), match.robot.Now()));
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_TRUE(match.Offer({MoveStep(0, 1, 0)}, 8)) << "it was sent once more";
}
// Its topic, or the service itself half a second ago, had brought it too late.
TEST(APlanThatAServiceHandsOut, IsNotTakenWhereItWasTooLateBefore) {
  Match match("meilin_stage.xml");
  match.RunFor(0.1);
  const auto plan = ToActionSequence({MoveStep(0, 1, 0)});
  match.mission.RefuseLate(plan, "it is too late");
  EXPECT_EQ(match.mission.refused_plan(), "it is too late");
  EXPECT_FALSE(match.mission.OfferHandedOut(plan, match.robot.Now()));
  match.RunFor(1);
  EXPECT_TRUE(match.robot.goals.empty());
  match.mission.NothingHandedOut();
  EXPECT_TRUE(match.mission.OfferHandedOut(plan, match.robot.Now())) << "it was sent once more";
}
TEST(APlanThatAServiceHandsOut, IsAnotherOneByItsContent) {
  Match match("meilin_stage.xml");
  EXPECT_TRUE(match.mission.OfferHandedOut(ToActionSequence({MoveStep(0, 1, 0)}), {}));
  EXPECT_TRUE(match.mission.OfferHandedOut(ToActionSequence({MoveStep(0, 2, 0)}), {}));
  EXPECT_FALSE(match.mission.OfferHandedOut(ToActionSequence({MoveStep(9, 2, 0)}), {}));
  EXPECT_EQ(match.mission.refusals(), 1U);
  EXPECT_FALSE(match.mission.OfferHandedOut(ToActionSequence({MoveStep(9, 2, 0)}), {}));
  EXPECT_EQ(match.mission.refusals(), 1U) << "twice a second";
}

// --- a start that waits ---

struct LateStart {
  explicit LateStart(Match& of) : match(of) {}
  void Begin(const std::string& region) {
    match.mission.StartSoon(region, match.robot.Now(), [this](const Result<std::string>& begun) {
      replies.push_back(begun ? begun.value() : begun.error().message);
    });
  }
  Match& match;
  std::vector<std::string> replies;
};

TEST(AStart, WaitsForTheFirstPoseOfARestartedMissionThatHasNotEndedAClimb) {
  Match match(Match::Waiting{}, "meilin_stage.xml");
  Progress progress;
  progress.climbing = true;
  ASSERT_TRUE(match.mission.Restore(progress));
  EXPECT_THAT(match.WhyNot("meilin"), HasSubstr("there is no fresh pose"));
  LateStart start(match);
  start.Begin("meilin");
  match.RunFor(1);
  EXPECT_TRUE(start.replies.empty());
  start.Begin("full");
  EXPECT_THAT(start.replies, ::testing::ElementsAre(HasSubstr("another start waits")));
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  match.RunFor(0.1);
  ASSERT_EQ(start.replies.size(), 2U);
  EXPECT_EQ(start.replies[1], "begins with the region meilin");
}
TEST(AStart, WaitsAtMostTwoSecondsAndSaysForWhat) {
  Match match(Match::Waiting{}, "meilin_stage.xml");
  Progress progress;
  progress.climbing = true;
  ASSERT_TRUE(match.mission.Restore(progress));
  LateStart start(match);
  start.Begin("meilin");
  match.RunFor(1.9);
  EXPECT_TRUE(start.replies.empty());
  match.RunFor(0.2);
  EXPECT_THAT(start.replies,
              ::testing::ElementsAre("a climb was not ended, and there is no fresh pose (after 2 s "
                                     "of waiting: no fresh pose)"));
  match.RunFor(5);
  EXPECT_TRUE(match.robot.goals.empty());
}
TEST(AStart, IsRefusedWhereTheRobotLeavesActiveBeforeThePoseComes) {
  Match match(Match::Waiting{}, "meilin_stage.xml");
  LateStart start(match);
  start.Begin("meilin");
  match.Pause();
  EXPECT_THAT(start.replies, ::testing::ElementsAre(HasSubstr("left Active before")));
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  match.RunFor(5);
  EXPECT_FALSE(match.mission.begun());
}
TEST(AStart, WaitsForTheWheelsThatReportedBeforeTheRestart) {
  Match match(Match::Waiting{}, "meilin_stage.xml");
  Progress progress;
  progress.wheels_mm = {20, 20, 20, 20};
  ASSERT_TRUE(match.mission.Restore(progress));
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  LateStart start(match);
  start.Begin("meilin");
  match.RunFor(0.5);
  EXPECT_TRUE(start.replies.empty());
  match.robot.legs = Wheels{{20, 20, 20, 20}, match.robot.Now()};
  match.RunFor(0.1);
  EXPECT_THAT(start.replies, ::testing::ElementsAre("begins with the region meilin"));
}
TEST(AStart, WaitsForTheSequenceOfTheSuspensionToEnd) {
  Match match(Match::Waiting{}, "meilin_stage.xml");
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  match.robot.sequence = 14;
  EXPECT_THAT(match.WhyNot("meilin"), StartsWith("the suspension is in state 14 of a sequence"));
  EXPECT_TRUE(match.mission.CanStart(match.robot.Now()).empty());
  LateStart start(match);
  start.Begin("meilin");
  match.RunFor(0.5);
  EXPECT_TRUE(start.replies.empty());
  match.robot.sequence = 0;
  match.RunFor(0.1);
  EXPECT_THAT(start.replies, ::testing::ElementsAre("begins with the region meilin"));
}

// --- plans of the old form ---

constexpr const char* kDrive = R"("move_target": {"x": 2.4, "y": 2.4, "yaw": 0})";
const std::string kClimb =
    std::string(R"({"segment_type": "CLIMB", "climb_mode": "UP", "climb_height": 200, )") + kDrive +
    "}";

TEST(AnOldPlan, IsCarriedOutByTheShippedTree) {
  Match match("segments.xml");
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  match.robot.r1_stays = true;
  match.RunFor(1);
  EXPECT_EQ(match.mission.state(), "WAITING_PLAN");
  const std::string start = R"("move_target": {"x": 1.2, "y": 1.2, "yaw": 0}})";
  ASSERT_TRUE(match.OfferOld(R"({"segment_type": "SPEAR_PREP", )" + start +
                                 R"(, {"segment_type": "SPEAR_GRASP"}, {"segment_type": "DOCK"},
             {"segment_type": "ALIGN", "move_target": {"x": 1.2, "y": 2.4, "yaw": 0}}, )" +
                                 kClimb +
                                 R"(, {"segment_type": "GRASP"}, {"segment_type": "STORE1"},
             {"segment_type": "EXIT", )" +
                                 kDrive + R"(}, {"segment_type": "FINAL_MOVE2", )" + kDrive +
                                 R"(}, {"segment_type": "PLACE_MID"}, {"segment_type": "FINISH"})",
                             7))
      << match.mission.refused_plan();
  EXPECT_TRUE(match.mission.WasTaken(7)) << "another process does not carry it out again";
  for (int i = 0; i < 5000 && !match.rests; ++i) {
    match.Tick();
    if (i == 100) FakeRobot::Raise(match.robot.r1, true);
  }
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS") << match.mission.last_error();
  EXPECT_EQ(match.mission.plan_id(), "segments_1");
  EXPECT_EQ(match.mission.GoesOnWith(), "");
  EXPECT_THAT(match.robot.Texts(),
              ::testing::ElementsAre("spear 1", "move 1.20 1.20 0", "spear 2", "spear 3", "spear 4",
                                     "move 1.20 2.40 0", "suspension up 0 200", "move 2.40 2.40 0",
                                     "arm 1", "arm 2", "move 2.40 2.40 0", "move 2.40 2.40 0",
                                     "arm 5", "suspension direct 0 30"))
      << "without the arm's 7, which it rejects";
}
TEST(AnOldPlan, BeginsOutsideOfTheField) {
  Match match(Match::Waiting{}, "segments.xml");
  match.robot.fix = PoseFix{0.3, 0, 0, match.robot.Now()};
  match.Begun("full");
  ASSERT_TRUE(match.OfferOld(R"({"segment_type": "ALIGN", "move_target": {"x": 0.5, "y": 0}})"));
  match.Run(20);
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS") << match.mission.last_error();
}
TEST(AnOldPlan, IsRefusedAsAWholeWhereAWayOfItCrossesAnEdge) {
  Match match("segments.xml");
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  EXPECT_FALSE(match.OfferOld(std::string(R"({"segment_type": "MOVE2", )") + kDrive + "}"));
  EXPECT_THAT(match.mission.refused_plan(), HasSubstr("crosses (1, 1), which has 200 mm"));
  EXPECT_FALSE(match.OfferOld(kClimb + R"(, {"segment_type": "GRASP"}, {"segment_type": "EXIT",
                                             "move_target": {"x": 1.2, "y": 2.4}})"));
  EXPECT_THAT(match.mission.refused_plan(), StartsWith("segments[2], EXIT: the straight way"));
  match.RunFor(5);
  EXPECT_TRUE(match.robot.goals.empty());
}
TEST(AnOldPlan, IsRefusedWhereAClimbOfItIsNoneFromWhereTheRobotIsThen) {
  Match match("segments.xml");
  match.robot.fix = PoseFix{1.2, 1.2, 0, match.robot.Now()};
  const auto why = [&match](const std::string& segments) {
    EXPECT_FALSE(match.OfferOld(segments)) << segments;
    return match.mission.refused_plan();
  };
  EXPECT_THAT(why(kClimb), HasSubstr("is not between two cells of the field that share an edge"));
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  EXPECT_THAT(why(R"({"segment_type": "CLIMB", "climb_mode": "UP", "climb_height": 400,
                      "move_target": {"x": 2.4, "y": 2.4}})"),
              HasSubstr("UP by 400 mm, and from (0, 1) to (1, 1) it is 200 mm up"));
  EXPECT_THAT(why(R"({"segment_type": "CLIMB", "climb_mode": "DOWN",
                      "move_target": {"x": 2.4, "y": 2.4}})"),
              HasSubstr("DOWN, and from (0, 1) to (1, 1) it is 200 mm up"));
  EXPECT_THAT(why(R"({"segment_type": "CLIMB", "climb_mode": "UP",
                      "move_target": {"x": 2.4, "y": 2.4, "yaw": 1.5708}})"),
              HasSubstr("climb_direction is forward, and with a yaw of 1.57 rad the way from "
                        "(0, 1) to (1, 1) is right"));
  match.RunFor(5);
  EXPECT_TRUE(match.robot.goals.empty());
}
TEST(AnOldPlan, EndsWhereAPauseHaltsItsClimb) {
  Match match("segments.xml");
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  match.robot.decide = [](const FakeGoal&) {
    return Outcome{GoalState::kSucceeded, "", Milliseconds(900)};
  };
  ASSERT_TRUE(match.OfferOld(kClimb));
  match.RunFor(0.3);
  ASSERT_EQ(match.robot.Running(), 2U);
  match.Pause();
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_THAT(match.mission.last_error(),
              StartsWith("segment 1 of 1, CLIMB 0: SuspensionControl was halted during a climb"));
  EXPECT_TRUE(match.mission.SavedProgress().climbing);
  const std::size_t goals = match.robot.goals.size();
  match.RunFor(5);
  EXPECT_EQ(match.robot.goals.size(), goals);
}
TEST(AnOldPlan, GoesOnInAnotherProcessWithTheSegmentThatWasNotDone) {
  Match before("segments.xml");
  before.robot.fix = PoseFix{1.2, 2.4, 0, before.robot.Now()};
  before.robot.decide = [](const FakeGoal& goal) {
    return goal.kind == Kind::kArm ? Outcome{GoalState::kAccepted} : Outcome{};
  };
  ASSERT_TRUE(before.OfferOld(kClimb + R"(, {"segment_type": "GRASP"}, {"segment_type": "EXIT", )" +
                              kDrive + "}"));
  before.RunFor(5);
  ASSERT_EQ(before.robot.Texts().back(), "arm 1");
  Match after(Match::Waiting{}, "segments.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  after.RunFor(5);
  EXPECT_EQ(after.mission.state(), "WAITING_START");
  EXPECT_TRUE(after.robot.goals.empty());
  EXPECT_EQ(after.mission.GoesOnWith(), "plan segments_1 at segment 2 of 3, GRASP");
  after.Begun("").Run(20);
  EXPECT_EQ(after.mission.state(), "MISSION_SUCCESS") << after.mission.last_error();
  EXPECT_THAT(after.robot.Texts(), ::testing::ElementsAre("arm 1", "move 2.40 2.40 0"));
  EXPECT_EQ(after.mission.SavedProgress().segments, "") << "it is done";
}
TEST(AnOldPlan, DoesNotGoOnWhereItsRestDoesNotFit) {
  Match before("segments.xml");
  before.robot.fix = PoseFix{1.2, 2.4, 0, before.robot.Now()};
  before.robot.decide = [](const FakeGoal& goal) {
    return goal.kind == Kind::kSuspension ? Outcome{GoalState::kFailed, "Timeout"} : Outcome{};
  };
  ASSERT_TRUE(before.OfferOld(kClimb));
  before.Run(20);
  ASSERT_EQ(before.mission.state(), "MISSION_FAILED");
  Match after(Match::Waiting{}, "segments.xml");
  ASSERT_NO_FATAL_FAILURE(Restart(before, after));
  after.robot.fix = PoseFix{1.2, 1.2, 0, after.robot.Now()};  // a person has put it there
  EXPECT_THAT(after.WhyNot(""), HasSubstr("does not fit where the robot is: segments[0], CLIMB"));
  EXPECT_EQ(after.WhyNot("meilin"), "") << "another plan may be sent";
  after.RunFor(1);
  EXPECT_TRUE(after.robot.goals.empty());
}
TEST(AnOldPlan, GoesOnBehindAClimbToWhoseEndTheRobotHasCome) {
  Match before("segments.xml");
  before.robot.fix = PoseFix{1.2, 2.4, 0, before.robot.Now()};
  before.robot.decide = [](const FakeGoal& goal) {
    return goal.kind == Kind::kSuspension ? Outcome{GoalState::kFailed, "Timeout"} : Outcome{};
  };
  ASSERT_TRUE(before.OfferOld(kClimb + R"(, {"segment_type": "GRASP"})"));
  before.Run(20);
  ASSERT_EQ(before.mission.state(), "MISSION_FAILED");
  before.robot.fix = PoseFix{2.4, 2.4, 0, before.robot.Now()};
  before.robot.decide = [](const FakeGoal&) { return Outcome{}; };
  const std::size_t goals = before.robot.goals.size();
  before.Begun("").Run(20);
  EXPECT_EQ(before.mission.state(), "MISSION_SUCCESS") << before.mission.last_error();
  EXPECT_EQ(before.robot.goals.size(), goals + 1);
  EXPECT_EQ(before.robot.Texts().back(), "arm 1");
}
TEST(AMission, RefusesAPlanOfAFormThatItsTreeDoesNotRun) {
  Match old("segments.xml");
  EXPECT_FALSE(old.Offer({MoveStep(0, 1, 0)}));
  EXPECT_THAT(old.mission.refused_plan(), HasSubstr("no node of it is PopNextMeilinSegment"));
  Match match("meilin_stage.xml");
  EXPECT_FALSE(match.OfferOld(R"({"segment_type": "GRASP"})"));
  EXPECT_THAT(match.mission.refused_plan(), HasSubstr("no node of it is PopNextSegment"));
}

TEST(AMission, GoesOnBehindThePartsOfTheFinalAreaThatAreDone) {
  Match match(Match::Waiting{}, "full_match.xml", MatchOf("simulated_blue.json"));
  match.robot.fix = PoseFix{7.2, 2.4, 0, match.robot.Now()};
  match.robot.arm.value = true;
  match.robot.decide = [](const FakeGoal& goal) {
    return goal.kind == Kind::kArm && goal.arm.command == 6 ? Outcome{GoalState::kFailed, "jammed"}
                                                            : Outcome{};
  };
  match.Begun("final").Run(60);
  ASSERT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_EQ(std::ranges::count(match.robot.Texts(), "arm 6"), 3) << "each part is tried again";
  EXPECT_FALSE(match.Offer({MoveStep(0, 1, 0)}));
  EXPECT_THAT(match.mission.refused_plan(), StartsWith("the part of the field is done"));
  EXPECT_THAT(match.mission.last_error(), HasSubstr("jammed")) << "and is not hidden";
  const std::size_t before = match.robot.goals.size();
  match.robot.decide = [](const FakeGoal&) { return Outcome{}; };
  match.Begun("").Run(60);
  EXPECT_EQ(match.mission.state(), "MISSION_SUCCESS");
  EXPECT_EQ(match.robot.goals.at(before)->Text(), "arm 6")
      << "no drive, no second box in the middle";
}
TEST(AMission, GoesOnAtADockThatHasJammed) {
  Match match("full_match.xml", MatchOf("match_blue.json"));
  MakeRealistic(match);
  match.robot.decide = [](const FakeGoal& goal) {
    return goal.kind == Kind::kSpear && goal.spear.command == 3
               ? Outcome{GoalState::kFailed, "jammed"}
               : Outcome{};
  };
  Play(match, 200);
  ASSERT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_EQ(std::ranges::count(match.robot.Texts(), "spear 3"), 3) << "it is tried again";
  const std::size_t before = match.robot.goals.size();
  match.robot.decide = [](const FakeGoal&) { return Outcome{}; };
  match.Begun("");
  Play(match, 1);
  EXPECT_EQ(match.robot.goals.at(before)->Text(), "spear 3");
}
TEST(AMission, TriesADockThatHasJammedOnceAgainByItselfWithAPartnerThatStaysReady) {
  Match match("full_match.xml", MatchOf("match_blue.json"));
  MakeRealistic(match);
  match.robot.r1_stays = true;
  int releases = 0;
  match.robot.decide = [&releases](const FakeGoal& goal) {
    const bool jams = goal.kind == Kind::kSpear && goal.spear.command == 4 && ++releases == 1;
    return jams ? Outcome{GoalState::kFailed, "jammed"} : Outcome{};
  };
  bool said = false;  // the partner says once that it is ready
  for (int i = 0; i < 10'000 && !match.mission.failed(); ++i) {
    match.Tick();
    const std::vector<std::string> texts = match.robot.Texts();
    if (!said && !texts.empty() && texts.back() == "spear 3") {
      FakeRobot::Raise(match.robot.r1, true);
      said = true;
    }
    if (releases == 2 && texts.back() == "move 1.20 1.20 0") break;  // it enters the field
  }
  EXPECT_EQ(releases, 2) << match.mission.last_error();
  EXPECT_EQ(match.robot.Texts().back(), "move 1.20 1.20 0") << match.mission.last_error();
}
TEST(AMission, HasNotSucceededWithItsWheelsOut) {
  Match match("meilin_stage.xml");
  match.robot.legs = Wheels{{20, 20, 20, 20}, match.robot.Now()};
  match.robot.legs_follow = false;
  match.robot.fix = PoseFix{1.2, 1.2, 0, match.robot.Now()};
  ASSERT_TRUE(match.Offer({FetchStep(1, 0, 400)}));
  match.robot.decide = [&match](const FakeGoal& goal) {
    if (goal.kind == Kind::kSuspension) match.robot.legs->mm.fill(430);
    return Outcome{};
  };
  match.Run(20);
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_THAT(match.mission.last_error(), HasSubstr("with its wheels out: 430, 430, 430, 430 mm"));
}
TEST(AMission, ChecksAPlanFromWhereTheRobotIsByWhatItHasDone) {
  Match match("meilin_stage.xml");
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), MoveStep(1, 1, 200)}));
  match.Run(20);  // no pose comes
  ASSERT_EQ(match.mission.state(), "MISSION_SUCCESS");
  EXPECT_TRUE(match.Offer({MoveStep(2, 1, 400)})) << match.mission.refused_plan();
}
TEST(AMission, DoesNotRunAStepOfAPlanFromAnotherCellThanItWasCheckedFrom) {
  const auto carried = [](const PlanStep& step, Point2 to) {
    Match match("meilin_stage.xml");
    match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
    EXPECT_TRUE(match.Offer({step})) << match.mission.refused_plan();
    match.robot.fix = PoseFix{to.x_m, to.y_m, 0, match.robot.Now()};
    match.Run(5);
    EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
    EXPECT_TRUE(match.robot.goals.empty());
    return match.mission.last_error();
  };
  EXPECT_THAT(carried(FetchStep(1, 1, 200), {2.4, 1.2}),
              HasSubstr("Fetch was checked from (0, 1), and the robot is on (1, 0)"));
  EXPECT_THAT(carried(MoveStep(1, 1, 200), {3.6, 2.4}),
              HasSubstr("Move was checked from (0, 1), and the robot is on (2, 1)"));
}
// A plan that comes during a move is checked from its end, and the robot has not arrived there.
TEST(AMission, BeginsNoClimbFromTheEndOfAMoveThatItsPoseContradicts) {
  Match match("meilin_stage.xml");
  const auto stay = [&match] { match.robot.fix = PoseFix{2.4, 2.4, 0, match.robot.Now()}; };
  stay();
  ASSERT_TRUE(match.Offer({MoveStep(2, 1, 400)})) << match.mission.refused_plan();
  for (int i = 0; i < 100 && match.robot.goals.empty(); ++i) match.Tick();
  const std::size_t goals = match.robot.goals.size();
  ASSERT_GT(goals, 0U) << match.mission.last_error();
  ASSERT_TRUE(match.Offer({MoveStep(2, 1, 400)})) << match.mission.refused_plan();
  for (int i = 0; i < 10'000 && !match.mission.failed(); ++i) {
    match.Tick();
    stay();
  }
  EXPECT_THAT(match.mission.last_error(),
              HasSubstr("Move was checked from (2, 1), and the robot is on (1, 1)"));
  EXPECT_EQ(match.robot.goals.size(), goals) << "of the first plan only";
}
TEST(AMission, HasAllBoxesOnTheFieldWhenAFullMatchBegins) {
  Match match("meilin_stage.xml");
  match.robot.fix = PoseFix{1.2, 2.4, 0, match.robot.Now()};
  ASSERT_TRUE(match.Offer({FetchStep(1, 1, 200), MoveStep(0, 1, 0)}));
  match.Run(30);
  ASSERT_EQ(match.mission.state(), "MISSION_SUCCESS") << match.mission.last_error();
  EXPECT_FALSE(match.Offer({FetchStep(1, 1, 200)}));
  match.Begun("full");
  EXPECT_TRUE(match.Offer({FetchStep(1, 1, 200)})) << match.mission.refused_plan();
}
TEST(AMission, RefusesAPlanAgainstTheMapOfBoxes) {
  Match match("meilin_stage.xml");
  BoxMap map;
  map.boxes[1][1] = Box::kKfs2;
  map.boxes[1][0] = Box::kFake;
  match.mission.SetBoxes(map);
  EXPECT_FALSE(match.Offer({MoveStep(0, 1, 0), MoveStep(1, 1, 200)}));
  EXPECT_THAT(match.mission.refused_plan(),
              HasSubstr("drives over (1, 1), where the map has a box"));
  EXPECT_FALSE(match.Offer({FetchStep(1, 0, 400)}));
  EXPECT_THAT(match.mission.refused_plan(), HasSubstr("the map has a fake box there"));
  EXPECT_FALSE(match.Offer({MoveStep(0, 2, 0), FetchStep(1, 2, 400)}));
  EXPECT_THAT(match.mission.refused_plan(), HasSubstr("the map has no box there"));
  ASSERT_TRUE(match.Offer({MoveStep(0, 1, 0), FetchStep(1, 1, 200), MoveStep(0, 1, 0)}))
      << match.mission.refused_plan();
  match.Run(30);
  ASSERT_EQ(match.mission.state(), "MISSION_SUCCESS") << match.mission.last_error();
  EXPECT_FALSE(match.Offer({FetchStep(1, 1, 200)}));
  EXPECT_THAT(match.mission.refused_plan(), HasSubstr("its box is already taken"));
  EXPECT_TRUE(match.Offer({MoveStep(1, 1, 200)})) << "it is not in the way any more";
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
    Match match("full_match.xml", MatchOf("simulated_" + std::string(SideText(side)) + ".json"),
                side);
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
