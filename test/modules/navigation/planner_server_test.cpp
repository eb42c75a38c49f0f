// planner_server on a simulated network, in virtual time; and its thread.

#include "musher/modules/navigation/planner_server/planner_server.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "musher/modules/navigation/server/thread_background.hpp"
#include "musher/test/modules/navigation/navigation_rig.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::navigation::planner_server_test {

using testing::At;
using ::testing::Contains;
using testing::GridOf;
using ::testing::HasSubstr;
using testing::MaskPeer;
using ::testing::Not;
using transport::GoalEnd;

class PlannerServerTest : public testing::NavigationRig {
 protected:
  void ExpectRefused(const msg::ComputePathToPose::Goal& goal, int code, const std::string& why) {
    const auto outcome = Plan(goal);
    EXPECT_EQ(outcome.end, GoalEnd::kAborted) << why;
    EXPECT_EQ(outcome.result.error_code, code) << why;
    EXPECT_THAT(log_, Contains(HasSubstr(why)));
    log_.clear();
    Run(2100);  // the same kind of warning is due again
  }
};

TEST_F(PlannerServerTest, PlansFromTheRobotOrFromTheGivenStart) {
  StartServers();
  const auto from_robot = Plan({.goal = At(3, 3)});
  ASSERT_EQ(from_robot.end, GoalEnd::kSucceeded);
  EXPECT_EQ(from_robot.result.error_code, 0);
  EXPECT_NEAR(from_robot.result.path.poses.front().pose.position.x, 1, 1e-6);
  const auto given = Plan({.goal = At(3, 3), .start = At(5, 3), .use_start = true});
  ASSERT_EQ(given.end, GoalEnd::kSucceeded);
  EXPECT_NEAR(given.result.path.poses.front().pose.position.x, 5, 1e-6);
}

TEST_F(PlannerServerTest, PublishesTheLastPathLatched) {
  StartServers();
  PathTo(3, 3);
  PathTo(2, 1);
  std::vector<msg::Path> paths;
  const auto late = Must(transport::MakeSubscription<msg::Path>(
      *peers_, "jetbot_0/planned_path",
      [&](const msg::Path& path, const auto&) { paths.push_back(path); }, transport::kLatchedQos));
  Run(500);
  ASSERT_EQ(paths.size(), 1U);
  EXPECT_NEAR(paths[0].poses.back().pose.position.x, 2, 1e-6);
}

TEST_F(PlannerServerTest, RefusesWhatItCannotPlanWithTheReason) {
  StartServers();
  ExpectRefused({.goal = At(3, 3), .planner_id = "Smac"}, 201, "expected '' or 'GridBased'");
  ExpectRefused({.goal = At(90, 3)}, 204, "is outside the map");
  ExpectRefused({.goal = At(3.8, 1)}, 206, "is in an obstacle");
  msg::ComputePathToPose::Goal goal{.goal = At(3, 3)};
  goal.goal.header.frame_id = "base_link";
  ExpectRefused(goal, 202, "goal: its frame is 'base_link', expected 'map'");
  goal = {.goal = At(3, 3)};
  goal.goal.pose.orientation = {0, 0, 0, 0};
  ExpectRefused(goal, 200, "goal: its orientation is (0, 0, 0, 0)");
  goal = {.goal = At(3, std::numeric_limits<double>::quiet_NaN())};
  ExpectRefused(goal, 200, "goal: it has a number that is not finite");
  ExpectRefused({.goal = At(3, 3), .start = At(3.8, 1), .use_start = true}, 205, "start");
}

TEST_F(PlannerServerTest, RefusesWithoutRecentOdometry) {
  StartServers();
  robot_.odometry_silent = true;
  Run(600);
  ExpectRefused({.goal = At(3, 3)}, 202, "no odometry on jetbot_0/odom for 0.6 s");
  EXPECT_EQ(Plan({.goal = At(3, 3), .start = At(2, 2), .use_start = true}).end,
            GoalEnd::kSucceeded);
}

TEST_F(PlannerServerTest, RefusesWithoutAMapAndFailsItsSelfCheck) {
  StartServers(false);
  ExpectRefused({.goal = At(3, 3)}, 200, "there is no map yet, on map");
  ASSERT_FALSE(planner_->Check().result());
  EXPECT_EQ(planner_->Check().result().error().code, 5309);
  EXPECT_EQ(planner_->Check().result().error().message, "jetbot_0: no map on map");
  EXPECT_TRUE(map_->Publish(testing::GridOf(walls_.map())));
  Run(500);
  EXPECT_TRUE(planner_->Check().result());
  EXPECT_EQ(Plan({.goal = At(3, 3)}).end, GoalEnd::kSucceeded);
}

TEST_F(PlannerServerTest, KeepsTheMapWhenTheNextOneCannotBeUsed) {
  StartServers();
  msg::OccupancyGrid bad = testing::GridOf(walls_.map());
  bad.data.pop_back();
  EXPECT_TRUE(map_->Publish(bad));
  Run(500);
  EXPECT_THAT(log_, Contains(HasSubstr("jetbot_0: a map is not used: map: it has")));
  EXPECT_THAT(log_, Contains(HasSubstr("the one before stays")));
  EXPECT_EQ(Plan({.goal = At(3, 3)}).end, GoalEnd::kSucceeded);
}

TEST_F(PlannerServerTest, RemembersWhatIsOutOfSight) {
  StartServers();
  robot_.discs = {{{3, 2, 0}, 0.2}};
  Run(500);
  robot_.discs.clear();
  robot_.scan_silent = true;
  Run(5000);
  EXPECT_EQ(Plan({.goal = At(5, 2)}).end, GoalEnd::kSucceeded);
  EXPECT_THAT(log_.back(), HasSubstr("around what its scan sees"));
  robot_.scan_silent = false;
  Run(500);
  EXPECT_EQ(Plan({.goal = At(5, 2)}).end, GoalEnd::kSucceeded);
  EXPECT_THAT(log_.back(), ::testing::Not(HasSubstr("around"))) << "rays pass where it was";
}

// By the pose at its arrival it would show the disc 0.6 m beside its place.
TEST_F(PlannerServerTest, TakesTheScansOfARobotThatTurnsFromWhereTheyWereTaken) {
  const testing::Disc disc{{3, 2, 0}, 0.2};
  robot_.discs = {disc};
  robot_.scan_late = Milliseconds(300);
  const auto wheels = Must(transport::MakePublisher<msg::Twist>(*peers_, "jetbot_0/cmd_vel"));
  StartServers();
  for (const double turn_rad_s : {1.0, -1.0}) {
    const auto turn = network_.now();
    while (network_.now() < turn + Milliseconds(3000)) {
      msg::Twist twist;
      twist.angular.z = turn_rad_s;
      EXPECT_TRUE(wheels->Publish(twist));
      Run(50);
    }
    const msg::Path path = PathTo(5, 2);
    for (std::size_t i = 1; i < path.poses.size(); ++i) {
      const auto &a = path.poses[i - 1].pose.position, &b = path.poses[i].pose.position;
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const Point at = Between({a.x, a.y, 0}, {b.x, b.y, 0}, share);
        EXPECT_GT(Distance(at, disc.at), disc.radius_m + 0.2) << turn_rad_s;
      }
    }
  }
}

TEST_F(PlannerServerTest, UsesANewMap) {
  StartServers();
  msg::OccupancyGrid blocked = testing::GridOf(walls_.map());
  std::fill(blocked.data.begin(), blocked.data.end(), 100);
  EXPECT_TRUE(map_->Publish(testing::GridOf(walls_.map())));
  EXPECT_TRUE(map_->Publish(blocked));
  Run(500);
  const auto refused = Plan({.goal = At(3, 3)}).result;
  EXPECT_EQ(refused.error_code, 206);
  EXPECT_THAT(refused.error_msg, ::testing::HasSubstr("(3.00, 3.00)"));
}

TEST_F(PlannerServerTest, EndsARequestAtItsLimit) {
  planner_config_.limit = Duration::zero();
  StartServers();
  ExpectRefused({.goal = At(6.5, 1)}, 207, "reached its time limit");
}

TEST_F(PlannerServerTest, CancelsARequestAtOnce) {
  planning_takes_ = Milliseconds(800);
  StartServers();
  Run(1000);
  const std::size_t goal = plans_.Send({.goal = At(3, 3)});
  Run(100);
  plans_.Cancel(goal);
  ASSERT_TRUE(RunUntil([&] { return plans_.ends[goal].has_value(); }, 200));
  EXPECT_EQ(plans_.ends[goal]->end, GoalEnd::kCanceled);
  Run(2000);
  EXPECT_THAT(log_, Not(Contains(HasSubstr("a path of")))) << "its path is dropped";
}

TEST_F(PlannerServerTest, ANewerGoalReplacesTheOneBefore) {
  planning_takes_ = Milliseconds(300);
  StartServers();
  const std::size_t first = plans_.Send({.goal = At(3, 3)});
  Run(100);
  const std::size_t second = plans_.Send({.goal = At(2, 1)});
  ASSERT_TRUE(RunUntil([&] { return plans_.ends[second].has_value(); }, 3000));
  ASSERT_TRUE(plans_.ends[first]);
  EXPECT_EQ(plans_.ends[first]->end, GoalEnd::kAborted);
  EXPECT_EQ(plans_.ends[second]->end, GoalEnd::kSucceeded);
  EXPECT_NEAR(plans_.ends[second]->result.path.poses.back().pose.position.x, 2, 1e-6);
}

TEST_F(PlannerServerTest, RejectsGoalsOutsideOfActiveAndEndsThePresentOne) {
  planning_takes_ = Milliseconds(300);
  StartServers();
  const std::size_t present = plans_.Send({.goal = At(3, 3)});
  Run(100);
  planner_->Permit(false, "it is in LowPower");
  Run(100);
  ASSERT_TRUE(plans_.ends[present]);
  EXPECT_EQ(plans_.ends[present]->end, GoalEnd::kAborted);
  EXPECT_EQ(Plan({.goal = At(3, 3)}).end, GoalEnd::kRejected);
  EXPECT_THAT(log_, Contains("jetbot_0: a goal is rejected: it is in LowPower"));
  planner_->Permit(true, "");
  EXPECT_EQ(Plan({.goal = At(3, 3)}).end, GoalEnd::kSucceeded);
}

TEST_F(PlannerServerTest, ForgetsThePlaceOfTheRobotWhenTheWorldIsRestarted) {
  StartServers();
  robot_.odometry_silent = true;
  Run(50);
  planner_->OnTimeJump("the time has jumped");
  ExpectRefused({.goal = At(3, 3)}, 202, "no odometry on jetbot_0/odom yet");
}

TEST_F(PlannerServerTest, IsDestroyedInTheMiddleOfARequest) {
  planning_takes_ = Milliseconds(300);
  StartServers();
  const std::size_t goal = plans_.Send({.goal = At(3, 3)});
  Run(100);
  planner_.reset();
  Run(1000);
  EXPECT_TRUE(plans_.ends[goal]);
}

TEST(ThreadBackground, LeavesTheLoopFreeAndReturnsThere) {
  transport::LinuxEventLoop loop;
  std::atomic<bool> release = false;
  bool loop_ran = false, returned = false;
  const std::thread::id here = std::this_thread::get_id();
  ThreadBackground thread(loop);
  thread.Do([&] {
    EXPECT_NE(std::this_thread::get_id(), here);
    while (!release) std::this_thread::yield();
    return [&] {
      EXPECT_EQ(std::this_thread::get_id(), here);
      returned = true;
    };
  });
  loop.Post([&] { loop_ran = true; });
  const Time deadline = loop.Now() + std::chrono::seconds(120);
  ASSERT_TRUE(loop.RunUntil([&] { return loop_ran; }, deadline));
  EXPECT_FALSE(returned);
  release = true;
  EXPECT_TRUE(loop.RunUntil([&] { return returned; }, deadline));
}

TEST(ThreadBackground, DropsItsWorkWhenItIsDestroyed) {
  transport::LinuxEventLoop loop;
  std::atomic<bool> release = false;
  std::atomic<int> works = 0;
  bool returned = false;
  {
    ThreadBackground thread(loop);
    thread.Do([&] {
      while (!release) std::this_thread::yield();
      ++works;
      return [&] { returned = true; };
    });
    release = true;
  }
  bool after = false;
  loop.Post([&] { after = true; });
  EXPECT_TRUE(loop.RunUntil([&] { return after; }, loop.Now() + std::chrono::seconds(120)));
  EXPECT_FALSE(returned);
  EXPECT_LE(works, 1);
}

// How far a path stays from the square of 1.5 to 2.5 m; between its poses as well, which may be far
// apart on a straight line.
double GapToSquareM(const msg::Path& path) {
  constexpr int kSteps = 200;
  double gap_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < path.poses.size(); ++i) {
    const auto &a = path.poses[i - 1].pose.position, &b = path.poses[i].pose.position;
    for (int step = 0; step <= kSteps; ++step) {
      const double x_m = std::lerp(a.x, b.x, step / double{kSteps});
      const double y_m = std::lerp(a.y, b.y, step / double{kSteps});
      gap_m = std::min(gap_m, std::hypot(std::max({0.0, 1.5 - x_m, x_m - 2.5}),
                                         std::max({0.0, 1.5 - y_m, y_m - 2.5})));
    }
  }
  return gap_m;
}

TEST_F(PlannerServerTest, PlansAroundTheCellsOfAMaskToKeepOutOf) {
  const double body_m = planner_config_.robots[0].radius_m;
  MaskPeer mask(*peers_, "keepout_filter_info");
  StartServers();
  EXPECT_EQ(GapToSquareM(PathTo(3, 2)), 0) << "straight ahead";
  mask.Publish(msg::CostmapFilterInfo::kKeepout, {1.5, 1.5, 0}, 1, 100);
  Run(1000);
  EXPECT_GE(GapToSquareM(PathTo(3, 2)), body_m);
  EXPECT_TRUE(map_->Publish(GridOf(walls_.map())));
  Run(1000);
  EXPECT_GE(GapToSquareM(PathTo(3, 2)), body_m) << "a new map keeps it";
  EXPECT_EQ(Plan({.goal = At(2, 2)}).result.error_code, 206) << "no goal in it";
}

TEST_F(PlannerServerTest, TakesAMaskThatWasPublishedBeforeItsStart) {
  MaskPeer mask(*peers_, "keepout_filter_info");
  mask.Publish(msg::CostmapFilterInfo::kKeepout, {1.5, 1.5, 0}, 1, 100);
  Run(1000);
  StartServers();
  EXPECT_GE(GapToSquareM(PathTo(3, 2)), planner_config_.robots[0].radius_m);
}

}  // namespace musher::navigation::planner_server_test
