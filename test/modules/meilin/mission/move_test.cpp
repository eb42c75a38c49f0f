// Move and Fetch: the goals that they send, and each of their failures.

#include "musher/test/modules/meilin/mission/match.hpp"

namespace musher::meilin::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using tree::Status;

std::string MoveXml(int row, int col, double height_mm, double yaw_rad) {
  return "<Move move_row=\"" + std::to_string(row) + "\" move_col=\"" + std::to_string(col) +
         "\" target_height_mm=\"" + std::to_string(height_mm) + "\" target_yaw=\"" +
         std::to_string(yaw_rad) + "\"/>";
}
std::string FetchXml(int row, int col, double difference_mm, double yaw_rad) {
  return "<Fetch kfs_row=\"" + std::to_string(row) + "\" kfs_col=\"" + std::to_string(col) +
         "\" height_diff=\"" + std::to_string(difference_mm) + "\" target_yaw=\"" +
         std::to_string(yaw_rad) + "\"/>";
}

struct NodeMatch : Match {
  explicit NodeMatch(const std::string& xml) : Match(FromText{xml}) {}
  void At(double x_m, double y_m, double yaw_rad = 0) {
    robot.fix = PoseFix{x_m, y_m, yaw_rad, robot.Now()};
  }
  void End(Kind kind, Outcome outcome) {
    robot.decide = [kind, outcome](const FakeGoal& goal) {
      return goal.kind == kind ? outcome : Outcome{};
    };
  }
  std::string error() const { return mission.last_error(); }
};

TEST(MeilinMove, AFlatMoveIsOneDriveToTheCentre) {
  NodeMatch match(MoveXml(0, 1, 0, 0));
  match.At(1.2, 1.2);
  match.Run(5);
  EXPECT_EQ(match.last, Status::kSuccess);
  EXPECT_THAT(match.robot.Texts(), ElementsAre("move 1.20 2.40 0"));
  EXPECT_EQ(match.board->col.Get(), 1);
  EXPECT_EQ(match.mission.state(), "ACTION_SUCCESS");
}
TEST(MeilinMove, AClimbRunsTogetherWithTheWay) {
  NodeMatch match(MoveXml(1, 1, 200, 0));
  match.At(1.2, 2.4);
  match.Tick();
  EXPECT_THAT(match.robot.Texts(), ElementsAre("move 2.40 2.40 0", "suspension up 0 200"));
  match.Run(5);
  EXPECT_EQ(match.board->height_mm.Get(), 200);
}
TEST(MeilinMove, TheDirectionOfAClimbIsThatOfTheBody) {
  NodeMatch match(MoveXml(1, 1, 200, kPi / 2));  // the robot looks to the left, and goes forward
  match.At(1.2, 2.4, kPi / 2);
  match.Tick();
  EXPECT_THAT(match.robot.Texts(), ElementsAre("move 2.40 2.40 90", "suspension up 2 200"));
}
TEST(MeilinMove, AClimbBeginsAtTheCentreWithTheHeadingOfTheTarget) {
  NodeMatch match(MoveXml(1, 1, 200, 0));
  match.At(1.4, 2.4, 1.0);
  match.Run(5);
  EXPECT_THAT(match.robot.Texts(),
              ElementsAre("move 1.20 2.40 0", "move 2.40 2.40 0", "suspension up 0 200"));
}
TEST(MeilinMove, WheelsThatAFetchHasLiftedAreLoweredBefore) {
  NodeMatch match(MoveXml(0, 2, 0, 0));
  match.At(1.2, 2.4);
  match.board->suspension_offset_mm.Set(200);
  match.Run(5);
  EXPECT_THAT(match.robot.Texts(), ElementsAre("suspension direct 0 30", "move 1.20 3.60 0"));
  EXPECT_EQ(match.board->suspension_offset_mm.Get(), 0);
}
TEST(MeilinMove, WheelsThatAFetchHasLiftedStayUpForAClimbUp) {
  NodeMatch match(MoveXml(1, 1, 200, 0));
  match.At(1.2, 2.4);
  match.board->suspension_offset_mm.Set(200);
  match.Run(5);
  EXPECT_THAT(match.robot.Texts(), ElementsAre("move 2.40 2.40 0", "suspension up 0 200"))
      << "no way down to the normal height and up again";
  EXPECT_EQ(match.board->suspension_offset_mm.Get(), 0);
}
TEST(MeilinMove, DoesNotGoStraightOverAPlatformOfAnotherHeight) {
  NodeMatch match(MoveXml(1, 2, 400, 0));
  match.At(2.4, 1.2);
  match.Tick();
  EXPECT_THAT(match.error(),
              StartsWith("Move from (1, 0) to (1, 2) crosses (1, 1), which has 200"));
  EXPECT_TRUE(match.robot.goals.empty());
}
TEST(MeilinMove, DoesNotBeginOnAnEdge) {
  NodeMatch match(MoveXml(0, 1, 0, 0));
  match.At(1.75, 2.4);  // the hull is 0.25 m over (1, 1)
  match.robot.legs = Wheels{{205, 205, 205, 205}, match.robot.Now()};
  match.Tick();
  EXPECT_THAT(match.error(), StartsWith("Move does not begin on the edge of (1, 1) and (0, 1)"));
  EXPECT_TRUE(match.robot.goals.empty());
}
TEST(MeilinMove, DoesNotBeginWhereItIsNotKnownHowItStandsOnAnEdge) {
  NodeMatch match(MoveXml(0, 1, 0, 0));
  match.At(1.75, 2.4);
  match.Tick();
  EXPECT_THAT(match.error(), HasSubstr("the wheels do not report; put it on a cell by hand"));
  EXPECT_TRUE(match.robot.goals.empty());
}
TEST(MeilinMove, HasNotSucceededWhileTheWheelsAreOut) {
  NodeMatch match(MoveXml(1, 1, 200, 0));
  match.At(1.2, 2.4);
  match.robot.legs = Wheels{{20, 20, 20, 20}, match.robot.Now()};
  match.robot.decide = [&match](const FakeGoal& goal) {
    if (goal.kind == Kind::kSuspension) match.robot.legs->mm = {410, 410, 410, 410};
    return Outcome{};
  };
  match.robot.legs_follow = false;
  match.Run(5);
  EXPECT_EQ(match.last, Status::kFailure);
  EXPECT_THAT(match.error(), HasSubstr("its wheels are still out: 410, 410, 410, 410 mm"));
}
TEST(MeilinMove, HasNotSucceededWithItsBodyAtAnotherHeight) {
  NodeMatch match(MoveXml(1, 1, 200, 0));
  match.At(1.2, 2.4);
  match.robot.z_m = 0.42;
  match.Run(5);
  EXPECT_EQ(match.last, Status::kFailure);
  EXPECT_THAT(match.error(), HasSubstr("its body is at 420 mm, on a platform of 200 mm"));
}
TEST(MeilinMove, LowersTheWheelsThatAreOutWhateverItRemembers) {
  NodeMatch match(MoveXml(0, 2, 0, 0));
  match.At(1.2, 2.4);
  match.robot.legs = Wheels{{230, 230, 230, 230}, match.robot.Now()};
  match.Run(5);
  EXPECT_THAT(match.robot.Texts(), ElementsAre("suspension direct 0 30", "move 1.20 3.60 0"));
}
TEST(MeilinMove, WithoutAFreshPoseItStartsFromTheRememberedCellWithAWarning) {
  NodeMatch match(MoveXml(0, 1, 0, 0));
  match.At(2.4, 2.4);
  match.robot.follows = false;
  match.RunFor(0.01);
  match.robot.fix->at = match.robot.Now() - Milliseconds(2000);
  NodeMatch stale(MoveXml(1, 0, 400, 0));
  stale.Tick();
  EXPECT_THAT(stale.robot.Texts(), ElementsAre("move 2.40 1.20 0", "suspension up 0 400"));
  EXPECT_EQ(stale.robot.warnings.size(), 1U);
}
TEST(MeilinMove, FailsOutsideTheGrid) {
  NodeMatch match(MoveXml(0, 1, 0, 0));
  match.At(-3, 0);
  match.Tick();
  EXPECT_EQ(match.last, Status::kFailure);
  EXPECT_THAT(match.error(), StartsWith("Current /transformed/pose is outside Meilin grid"));
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_TRUE(match.robot.goals.empty());
}
TEST(MeilinMove, NeedsItsTarget) {
  NodeMatch match("<Move move_row=\"1\" target_yaw=\"0\"/>");
  match.Tick();
  EXPECT_EQ(match.error(), "Move missing move_row/move_col/target_yaw");
}
TEST(MeilinMove, RefusesAClimbAcrossCells) {
  NodeMatch match(MoveXml(2, 2, 200, 0));
  match.At(1.2, 1.2);
  match.Tick();
  EXPECT_THAT(match.error(), StartsWith("Move climb direction is invalid"));
}

struct Failure {
  const char* name;
  Kind kind;
  Outcome outcome;
  const char* text;
};

class MeilinMoveFailure : public ::testing::TestWithParam<Failure> {};

TEST_P(MeilinMoveFailure, IsNamedAndLeavesNoGoal) {
  NodeMatch match(MoveXml(1, 1, 200, 0));
  match.At(1.2, 2.4);
  match.End(GetParam().kind, GetParam().outcome);
  match.Run(60);
  EXPECT_EQ(match.last, Status::kFailure);
  EXPECT_THAT(match.error(), StartsWith(GetParam().text));
  EXPECT_EQ(match.mission.state(), "MISSION_FAILED");
  EXPECT_EQ(match.robot.Running(), 0U);
}

INSTANTIATE_TEST_SUITE_P(
    All, MeilinMoveFailure,
    ::testing::Values(
        Failure{"NoDrive",
                Kind::kMove,
                {GoalState::kUnavailable},
                "Motion_control_accurate /move_to_pose action server not available"},
        Failure{"NoSuspension",
                Kind::kSuspension,
                {GoalState::kUnavailable},
                "SuspensionControl action server not available"},
        Failure{
            "DriveRejected", Kind::kMove, {GoalState::kRejected}, "Goal rejected by move_to_pose"},
        Failure{"SuspensionRejected",
                Kind::kSuspension,
                {GoalState::kRejected},
                "Goal rejected by suspension_control"},
        Failure{"DriveNeverEnds", Kind::kMove, {GoalState::kAccepted}, "target_align timed out"},
        Failure{"SuspensionNeverEnds",
                Kind::kSuspension,
                {GoalState::kAccepted},
                "SuspensionControl timed out"},
        Failure{"SuspensionTimeout",
                Kind::kSuspension,
                {GoalState::kFailed, "Timeout"},
                "suspension_control: Timeout after 0 s (SuspensionControl, of at most 15 s)"},
        Failure{"DriveFailed",
                Kind::kMove,
                {GoalState::kFailed, "XY phase timed out"},
                "move_to_pose: XY phase timed out after 0 s (target_align, of at most 30 s)"},
        Failure{"DriveLost",
                Kind::kMove,
                {GoalState::kLost, "no answer"},
                "target_align lost its server move_to_pose: no answer"}),
    [](const auto& each) { return each.param.name; });

TEST(MeilinMove, AHaltCancelsBothGoalsAndNamesTheClimb) {
  NodeMatch match(MoveXml(1, 1, 200, 0));
  match.At(1.2, 2.4);
  match.End(Kind::kSuspension, {GoalState::kAccepted});
  match.RunFor(0.02);
  EXPECT_EQ(match.robot.Running(), 2U);
  ASSERT_TRUE(match.tree->Halt(match.robot.Now()));
  EXPECT_EQ(match.robot.Running(), 0U);
  EXPECT_THAT(match.error(), StartsWith("Move was halted during a climb"));
}

TEST(MeilinFetch, DrivesLiftsAndGrasps) {
  NodeMatch match(FetchXml(1, 0, 400, 0));
  match.Run(5);
  EXPECT_EQ(match.last, Status::kSuccess);
  EXPECT_THAT(match.robot.Texts(),
              ElementsAre("move 1.40 1.20 0", "suspension direct 0 430", "arm 1"));
  EXPECT_EQ(match.board->suspension_offset_mm.Get(), 400);
  EXPECT_FALSE(match.board->is_cell_center.Get());
  EXPECT_EQ(match.board->row.Get(), 0);
}
TEST(MeilinFetch, WithoutADifferenceTheWheelsStay) {
  NodeMatch match(FetchXml(0, 1, 0, kPi / 2));
  match.Run(5);
  EXPECT_THAT(match.robot.Texts(), ElementsAre("move 1.20 1.40 90", "arm 1"));
}
TEST(MeilinFetch, RefusesAHeightBelowTheGround) {
  NodeMatch match(FetchXml(1, 0, -200, 0));
  match.Tick();
  EXPECT_THAT(match.error(), StartsWith("Fetch suspension height is negative"));
  EXPECT_TRUE(match.robot.goals.empty());
}
TEST(MeilinFetch, StartsFromTheLivePoseAndNotFromTheRememberedCell) {
  NodeMatch match(FetchXml(2, 1, 200, 0));
  match.At(2.4, 2.4);  // on (1, 1); remembered is (0, 0)
  match.Run(5);
  EXPECT_THAT(match.robot.Texts(),
              ElementsAre("move 2.60 2.40 0", "suspension direct 0 230", "arm 1"));
}
TEST(MeilinFetch, RefusesABoxThatIsNotBesideIt) {
  NodeMatch match(FetchXml(3, 0, 0, 0));
  match.Tick();
  EXPECT_THAT(match.error(), StartsWith("Fetch KFS grid (3, 0) must be adjacent"));
}
TEST(MeilinFetch, NeedsItsBox) {
  NodeMatch match("<Fetch kfs_row=\"1\"/>");
  match.Tick();
  EXPECT_EQ(match.error(), "Fetch missing kfs_row/kfs_col/target_yaw");
}
TEST(MeilinFetch, AnArmThatNeverEndsTimesOut) {
  NodeMatch match(FetchXml(1, 0, 400, 0));
  match.End(Kind::kArm, {GoalState::kAccepted});
  match.Run(60);
  EXPECT_THAT(match.error(), StartsWith("ArmAction timed out"));
  EXPECT_EQ(match.robot.Running(), 0U);
  EXPECT_EQ(match.board->suspension_offset_mm.Get(), 400) << "the wheels are still lifted";
}
TEST(MeilinFetch, AMissingArmIsNamed) {
  NodeMatch match(FetchXml(1, 0, 400, 0));
  match.End(Kind::kArm, {GoalState::kUnavailable});
  match.Run(60);
  EXPECT_THAT(match.error(), StartsWith("ArmAction action server not available"));
}

}  // namespace
}  // namespace musher::meilin::testing
