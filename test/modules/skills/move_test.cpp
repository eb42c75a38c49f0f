// move: its loops, and what it refuses.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::move_test {

using skill::Status;
using skills::testing::SkillsOnARobot;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Move : public ::testing::Test, public SkillsOnARobot {
 protected:
  std::string WhyRefused(const std::string& path, const std::string& loops = "0") {
    EXPECT_TRUE(Start("move", {{"path", path}, {"loops", loops}}));
    Step();
    EXPECT_EQ(feedback().status, Status::kFailed);
    return feedback().message;
  }
};

TEST_F(Move, VisitsItsWayPointsInOrderSoManyTimes) {
  ASSERT_TRUE(Start("move", {{"path", "[[2, 0], [2, 2], [0, 0]]"}, {"loops", "2"}}));
  EXPECT_TRUE(RunToItsEnd(60));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(feedback().message, "Path completed (3 way-points, 2 loops)");
  ASSERT_EQ(robot.driven_paths.size(), 6U);
  EXPECT_EQ(robot.driven_paths[1].back().at, (navigation::Point{2, 2, 0}));
  EXPECT_EQ(robot.driven_paths[3].back().at, (navigation::Point{2, 0, 0}));
}

TEST_F(Move, GoesOnUntilItIsCancelled) {
  ASSERT_TRUE(Start("move", {{"path", "[[1, 0], [0, 0]]"}}));
  RunFor(3600);
  EXPECT_EQ(feedback().status, Status::kProcessing) << feedback().message;
  EXPECT_GT(robot.drives, 500);
  ASSERT_TRUE(manager->Cancel("move", "enough"));
  EXPECT_TRUE(RunToItsEnd(5));
  EXPECT_EQ(feedback().status, Status::kCancelled);
  EXPECT_TRUE(robot.Rests());
}

TEST_F(Move, SaysWhichWayPointItGoesTo) {
  ASSERT_TRUE(Start("move", {{"path", "[[2, 0], [2, 2], [0, 0]]"}, {"loops", "1"}}));
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(1);
  EXPECT_THAT(feedback().message, StartsWith("Way-point 1 of 3: Moving... ("));
  RunFor(3);
  EXPECT_THAT(feedback().message, StartsWith("Way-point 2 of 3: "));
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return Error{kCodeFailed, "no path"};
  };
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().message, "Way-point 3 of 3: Planning failed: no path");
}

TEST_F(Move, ContinuesAtTheSameWayPointAfterAPauseAndALostController) {
  ASSERT_TRUE(Start("move", {{"path", "[[3, 0], [3, 3]]"}, {"loops", "1"}}));
  RunFor(5);
  Pause();
  RunFor(60);
  EXPECT_TRUE(robot.Rests());
  Resume();
  RunFor(1);
  robot.KillController();
  RunFor(4);
  robot.controller_up = true;
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(robot.driven_paths.size(), 4U);
}

TEST_F(Move, RefusesAPathThatIsNone) {
  EXPECT_EQ(WhyRefused("[]"), "path has no way-points");
  EXPECT_EQ(WhyRefused("[[1, 2]]"), "path has one place; a loop needs at least two");
  EXPECT_EQ(WhyRefused("[[1, 2], [3, 4]]", "-1"), "loops is -1; expected 0 or more");
  EXPECT_THAT(WhyRefused("[1, 2]"), HasSubstr("path, character 2: expected '['"));
  robot.robot_kind = "cf2x";
  EXPECT_EQ(WhyRefused("[[1, 2, 1], [3, 4]]"),
            "Invalid altitude: way-point 2 is at 0.00 m; expected more than 0 m");
}

}  // namespace musher::move_test
