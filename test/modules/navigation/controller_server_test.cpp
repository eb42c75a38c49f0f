// controller_server on a simulated network with a simulated differential robot, in virtual time.

#include "musher/modules/navigation/controller_server/controller_server.hpp"

#include <cstring>
#include <limits>

#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/messages/tf2_msgs/tf_message.hpp"
#include "musher/test/modules/navigation/navigation_rig.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/test/transport/suspended_node.hpp"

namespace musher::navigation::controller_server_test {

using testing::At;
using ::testing::Contains;
using ::testing::HasSubstr;
using transport::GoalEnd;

msg::Path PathOf(const std::vector<msg::PoseStamped>& poses) {
  msg::Path path;
  path.header.frame_id = "map";
  path.poses = poses;
  return path;
}

// The map with a box of this half width in it.
CellMap WithBox(CellMap map, const Point& middle, double half_m) {
  for (std::size_t i = 0; i < map.count(); ++i) {
    const Point at = map.CentreOf(map.CellAt(i));
    const bool inside =
        std::abs(at.x_m - middle.x_m) < half_m && std::abs(at.y_m - middle.y_m) < half_m;
    if (inside) map.blocked[i] = 1;
  }
  return map;
}

class ControllerServerTest : public testing::NavigationRig {
 protected:
  // Before StartServers(). The result is the time for which the server's computer was suspended,
  // and the test adds to it.
  Duration& MakeSuspendable() {
    auto node = std::make_unique<musher::testing::SuspendedNode>(network_.MakeNode("robot"));
    Duration& suspended = node->loop().suspended;
    controller_clock_ = transport::Clock::Steady(node->loop());
    controller_node_ = std::move(node);
    return suspended;
  }
  // On the way to (3, 2), with some speed.
  std::size_t StartDriving() {
    const std::size_t drive = Follow(PathOf({At(1, 2), At(6.5, 2)}));
    EXPECT_TRUE(RunUntil([&] { return robot_.speed_m_s() > 0.8; }, 5000));
    return drive;
  }
  void ExpectStanding() {
    EXPECT_EQ(robot_.last_command(), msg::Twist{});
    EXPECT_EQ(robot_.speed_m_s(), 0);
    const int commands = robot_.commands();
    Run(1000);
    EXPECT_EQ(robot_.commands(), commands) << "nothing is sent any more";
  }
};

TEST_F(ControllerServerTest, ArrivesWithinItsTolerancesAndSaysSo) {
  StartServers();
  const std::size_t drive = Follow(PathOf({At(1, 2), At(3, 2), At(3, 3.5, 3)}));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_EQ(drives_.ends[drive]->result.error_code, 0);
  EXPECT_NEAR(robot_.pose().at.x_m, 3, 0.2);
  EXPECT_NEAR(robot_.pose().at.y_m, 3.5, 0.2);
  EXPECT_NEAR(robot_.pose().yaw_rad, 3, 0.1);
  Run(100);
  ExpectStanding();
}

TEST_F(ControllerServerTest, ReportsThePathLeftTenTimesASecond) {
  StartServers();
  const std::size_t drive = Follow(PathOf({At(1, 2), At(6, 2)}));
  Run(500);
  drives_.feedback.clear();
  Run(2000);
  ASSERT_NEAR(double(drives_.feedback.size()), 20, 2);
  EXPECT_GT(drives_.feedback.front().distance_to_goal, 4);
  EXPECT_LT(drives_.feedback.back().distance_to_goal, 4);
  EXPECT_GT(drives_.feedback.back().speed, 1);
  EXPECT_TRUE(AwaitEnd(drive));
  EXPECT_LT(drives_.feedback.back().distance_to_goal, 0.25);
}

TEST_F(ControllerServerTest, PublishesTheTrajectoryOfADrive) {
  std::vector<msg::JointTrajectory> trajectories;
  const auto in = Must(transport::MakeSubscription<msg::JointTrajectory>(
      *peers_, "jetbot_0/timed_trajectory",
      [&](const msg::JointTrajectory& t, const auto&) { trajectories.push_back(t); }));
  StartServers();
  ASSERT_TRUE(AwaitEnd(Follow(PathOf({At(1, 2), At(3, 2)}))));
  ASSERT_EQ(trajectories.size(), 1U);
  EXPECT_EQ(trajectories[0].header.frame_id, "map");
  EXPECT_NEAR(trajectories[0].points.back().positions[0], 3, 1e-6);
}

TEST_F(ControllerServerTest, SendsStampedVelocitiesIfItsConfigSaysSo) {
  controller_config_.robots[0].stamped = true;
  std::vector<msg::TwistStamped> commands;
  const auto in = Must(transport::MakeSubscription<msg::TwistStamped>(
      *peers_, "jetbot_0/cmd_vel",
      [&](const msg::TwistStamped& command, const auto&) { commands.push_back(command); }));
  StartServers();
  Follow(PathOf({At(1, 2), At(3, 2)}));
  Run(500);
  ASSERT_FALSE(commands.empty());
  EXPECT_EQ(commands.back().header.frame_id, "base_link");
  EXPECT_GT(commands.back().twist.linear.x, 0);
}

TEST_F(ControllerServerTest, SendsVelocitiesAheadAndTurnsOnlyToADifferentialRobot) {
  StartServers();
  const std::size_t drive = Follow(PathOf({At(1, 2), At(2, 2.4), At(3, 3.5)}));
  int aside = 0;
  double fastest = 0;
  while (!drives_.ends[drive] && network_.Step()) {
    aside += robot_.last_command().linear.y != 0;
    fastest = std::max(fastest, robot_.last_command().linear.x);
  }
  EXPECT_EQ(aside, 0);
  EXPECT_GT(fastest, 0.7);
  EXPECT_LE(fastest, 1.5);
}

TEST_F(ControllerServerTest, KeepsASpeedLimitUntilItIsLifted) {
  StartServers();
  const auto limits = Must(transport::MakePublisher<msg::SpeedLimit>(*peers_, "speed_limit"));
  Run(500);
  const std::size_t drive = StartDriving();
  for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(limits->Publish({.percentage = false, .speed_limit = bad}));
  }
  EXPECT_TRUE(limits->Publish({.percentage = true, .speed_limit = 20}));  // of 1.5 m/s
  Run(2000);
  EXPECT_THAT(log_, Contains(HasSubstr("speed limit: 20.00 %")));
  EXPECT_LT(robot_.speed_m_s(), 0.31);
  EXPECT_GT(robot_.speed_m_s(), 0.2);
  EXPECT_TRUE(limits->Publish({.percentage = false, .speed_limit = 0}));
  EXPECT_TRUE(RunUntil([&] { return robot_.speed_m_s() > 0.8; }, 3000));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded);
}

TEST_F(ControllerServerTest, IsAsSlowAsTheMaskOfNav2SaysWhereItIs) {
  using Info = msg::CostmapFilterInfo;
  testing::MaskPeer mask(*peers_, "speed_filter_info");
  StartServers();
  mask.Publish(Info::kSpeedPercent, {3, 1, 0}, 2, 20);  // of 1.5 m/s
  Run(500);
  const std::size_t drive = Follow(PathOf({At(1, 2), At(6.5, 2)}));
  double inside_m_s = 0, outside_m_s = 0;
  while (!drives_.ends[drive] && network_.Step()) {
    const double x_m = robot_.pose().at.x_m;
    if (x_m > 4.6 && x_m < 4.9) inside_m_s = std::max(inside_m_s, robot_.speed_m_s());
    if (x_m < 3 || x_m > 5.2) outside_m_s = std::max(outside_m_s, robot_.speed_m_s());
  }
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_LT(inside_m_s, 0.32);
  EXPECT_GT(outside_m_s, 0.8);
  mask.Publish(Info::kBinary, {3, 1, 0}, 2, 20);
  Run(200);
  EXPECT_THAT(log_, Contains(HasSubstr("a mask is not used: its type is 3")));
}

TEST_F(ControllerServerTest, DrivesIntoNoCellToKeepOutOf) {
  testing::MaskPeer mask(*peers_, "keepout_filter_info");
  StartServers();
  const std::size_t drive = StartDriving();
  mask.Publish(msg::CostmapFilterInfo::kKeepout, {4, 1, 0}, 1.5, 100);
  ASSERT_TRUE(AwaitEnd(drive)) << "a drive that leads there ends";
  EXPECT_EQ(CodeOf(drive), 103);
  EXPECT_THAT(log_, Contains(HasSubstr("the path leads into cells to keep out of, at (4.")));
  Run(1000);
  EXPECT_LT(robot_.pose().at.x_m, 4);
  const std::size_t refused = Follow(PathOf({At(robot_.pose().at.x_m, 2), At(6.5, 2)}));
  ASSERT_TRUE(AwaitEnd(refused));
  EXPECT_EQ(CodeOf(refused), 103);
  EXPECT_LT(robot_.pose().at.x_m, 4);
}

TEST_F(ControllerServerTest, ArrivesAndMakesProgressByTheCheckersOfAGoal) {
  controller_config_.goal_checkers = {{"precise", 0.03, 0.03}};
  controller_config_.progress_checkers = {{"fast", {0.5, Milliseconds(1500)}},
                                          {"lenient", {0.1, std::chrono::seconds(60)}}};
  StartServers();
  msg::FollowPath::Goal goal{.path = PathOf({At(1, 2), At(3, 2)})};
  goal.goal_checker_id = "precise";
  goal.progress_checker_id = "lenient";
  const std::size_t precise = drives_.Send(goal);
  ASSERT_TRUE(AwaitEnd(precise));
  EXPECT_EQ(drives_.ends[precise]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_NEAR(robot_.pose().at.x_m, 3, 0.035);
  goal.goal_checker_id = "general";
  const std::size_t unknown = drives_.Send(goal);
  ASSERT_TRUE(AwaitEnd(unknown));
  EXPECT_EQ(drives_.ends[unknown]->result.error_msg,
            "there is no goal checker 'general' in the config");
  robot_.discs = {{{4, 2, 0}, 0.2}};
  Run(300);
  const std::size_t stands = Follow(PathOf({At(3, 2), At(6.5, 2)}));
  ASSERT_TRUE(AwaitEnd(stands));
  EXPECT_EQ(CodeOf(stands), 105);
  EXPECT_THAT(drives_.ends[stands]->result.error_msg,
              HasSubstr("not moved by 0.50 m within 1.5 s"));
}

// Of ROS 2's localisations: odometry in `odom`, which a transform places in the map.
TEST_F(ControllerServerTest, DrivesByOdometryInAFrameOfItsOwn) {
  robot_.odometry_frame = "odom";
  robot_.odometry_off = {-3, 1, 0};
  const auto tf = Must(transport::MakePublisher<msg::TfMessage>(*peers_, "tf"));
  StartServers();
  const std::size_t refused = Follow(PathOf({At(1, 2), At(3, 2)}));
  ASSERT_TRUE(AwaitEnd(refused));
  EXPECT_EQ(CodeOf(refused), 102) << "no transform";
  msg::TfMessage message;
  message.transforms.resize(1);
  message.transforms[0].header.frame_id = "map";
  message.transforms[0].child_frame_id = "odom";
  message.transforms[0].transform.translation = {3, -1, 0};
  auto publishing =
      peers_->loop().Every(Milliseconds(50), [&] { static_cast<void>(tf->Publish(message)); });
  Run(500);
  const std::size_t drive = Follow(PathTo(6.5, 2));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_NEAR(robot_.pose().at.x_m, 6.5, 0.2);
  publishing.reset();
  const std::size_t lost = Follow(PathOf({At(6.5, 2), At(1, 2)}));
  ASSERT_TRUE(AwaitEnd(lost));
  EXPECT_EQ(CodeOf(lost), 102) << "the localisation is lost";
  EXPECT_GT(robot_.pose().at.x_m, 3);
  Run(1000);
  ExpectStanding();
}

TEST_F(ControllerServerTest, ForgetsWhatItHasSeenOnRequest) {
  StartServers();
  const auto client =
      Must(transport::MakeClient<msg::Trigger>(*peers_, "jetbot_0/clear_controller_memory"));
  Run(500);
  bool cleared = false;
  client->Call({}, Milliseconds(1000),
               [&](const auto& reply) { cleared = reply && reply.value().success; });
  EXPECT_TRUE(RunUntil([&] { return cleared; }, 1000));
  EXPECT_THAT(log_, Contains(HasSubstr("what it has seen is forgotten")));
}

TEST_F(ControllerServerTest, StopsBeforeAnObstacleThatStaysAndNamesItsPlace) {
  StartServers();
  robot_.discs = {{{4, 2, 0}, 0.2}};
  const std::size_t drive = Follow(PathOf({At(1, 2), At(6.5, 2)}));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(CodeOf(drive), 104);
  EXPECT_THAT(log_, Contains(HasSubstr("jetbot_0: the drive has ended: an obstacle at (3.8")));
  EXPECT_LT(robot_.pose().at.x_m, 4 - 0.2 - 0.2);
  EXPECT_GT(robot_.pose().at.x_m, 2.8);
  Run(100);
  ExpectStanding();
}

TEST_F(ControllerServerTest, GoesOnWhenAnObstacleHasLeft) {
  StartServers();
  robot_.discs = {{{4, 2, 0}, 0.2}};
  const std::size_t drive = Follow(PathOf({At(1, 2), At(6.5, 2)}));
  ASSERT_TRUE(
      RunUntil([&] { return robot_.pose().at.x_m > 2 && robot_.speed_m_s() < 0.01; }, 20'000));
  robot_.discs.clear();
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
}

TEST_F(ControllerServerTest, IsNotSlowedDownByTheWallsOfTheMap) {
  StartServers();
  // 0.1 m more than the body and its margin from the wall.
  const std::size_t drive = Follow(PathOf({At(1, 2), At(1, 0.8), At(3.3, 0.8)}));
  double fastest = 0;
  while (!drives_.ends[drive] && network_.Step()) fastest = std::max(fastest, robot_.speed_m_s());
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_GT(fastest, 1.2);
}

TEST_F(ControllerServerTest, StopsBeforeAWallThatAPathLeadsThrough) {
  StartServers();
  const std::size_t drive = Follow(PathOf({At(1, 1), At(6.5, 1)}));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(CodeOf(drive), 104) << log_.back();
  EXPECT_LT(robot_.pose().at.x_m, 3.6 - 0.2);
}

// Every map server and SLAM has the obstacle in its next map.
TEST_F(ControllerServerTest, StopsBeforeAnObstacleThatANewMapContains) {
  StartServers();
  for (const double seen_at_m : {1.2, 2.0, 2.9}) {
    EXPECT_TRUE(map_->Publish(testing::GridOf(walls_.map())));
    Run(100);
    robot_.discs = {{{4, 2, 0}, 0.2}};
    const std::size_t drive = Follow(PathOf({At(1, 2), At(6.5, 2)}));
    ASSERT_TRUE(RunUntil([&] { return robot_.pose().at.x_m > seen_at_m; }, 10'000));
    EXPECT_TRUE(map_->Publish(testing::GridOf(WithBox(walls_.map(), {4, 2, 0}, 0.25))));
    ASSERT_TRUE(AwaitEnd(drive, 20'000)) << robot_.pose().at.x_m;
    EXPECT_EQ(CodeOf(drive), 104);
    EXPECT_LT(robot_.pose().at.x_m, 4 - 0.2 - 0.2) << "it has not touched it";
    robot_.discs.clear();
    const std::size_t back = Follow(PathOf({At(robot_.pose().at.x_m, 2), At(1, 2)}));
    ASSERT_TRUE(AwaitEnd(back));
  }
}

TEST_F(ControllerServerTest, TouchesNothingThatItsScanSeesWhenItsLocalisationIsWrong) {
  StartServers();
  for (const double off_m : {-0.9, -0.4, 0.4, 0.9}) {
    // Believed to be beside where it is: the way leads into the wall beside the door.
    robot_.odometry_off = {0, off_m, 0};
    const std::size_t drive = Follow(PathOf({At(1, 2 + off_m), At(6.5, 2 + off_m)}));
    AwaitEnd(drive, 40'000);
    EXPECT_TRUE(drives_.ends[drive]) << off_m;
    EXPECT_GT(robot_.least_room_m(), 0) << off_m;
    robot_.odometry_off = {};
    Run(1500);
    AwaitEnd(Follow(PathOf({At(robot_.pose().at.x_m, robot_.pose().at.y_m), At(1, 2)})), 40'000);
  }
}

TEST_F(ControllerServerTest, EndsADriveWhosePoseJumpsAndSaysSo) {
  StartServers();
  for (const double jump_m : {1.0, 30.0}) {
    const std::size_t drive = StartDriving();
    robot_.odometry_off = {jump_m, 0, 0};
    Run(100);
    ASSERT_TRUE(drives_.ends[drive]) << jump_m;
    EXPECT_EQ(CodeOf(drive), 102);
    EXPECT_THAT(log_, Contains(HasSubstr("the drive has ended: the pose has jumped by ")));
    ExpectStanding();
    robot_.odometry_off = {};
    AwaitEnd(Follow(PathOf({At(robot_.pose().at.x_m, 2), At(1, 2)})));
  }
}

TEST_F(ControllerServerTest, EndsADriveWhoseOdometryStandsWithFreshStamps) {
  StartServers();
  const std::size_t drive = StartDriving();
  robot_.odometry_frozen = true;
  Run(1500);
  ASSERT_TRUE(drives_.ends[drive]);
  EXPECT_EQ(CodeOf(drive), 105);
  EXPECT_THAT(log_, Contains(HasSubstr("its odometry does not change at all")));
  EXPECT_GT(robot_.least_room_m(), 0);
  ExpectStanding();
}

TEST_F(ControllerServerTest, TakesOdometryWhoseStampsStandForNone) {
  StartServers();
  const std::size_t drive = StartDriving();
  robot_.stamps_stand = true;
  Run(600);
  ASSERT_TRUE(drives_.ends[drive]);
  EXPECT_EQ(CodeOf(drive), 102);
  ExpectStanding();
}

TEST_F(ControllerServerTest, IsLateAlsoAfterAnObstacleHasSlowedItDown) {
  StartServers();
  robot_.discs = {{{4, 2.45, 0}, 0.1}};
  const std::size_t drive = Follow(PathOf({At(1, 2), At(6.5, 2)}));
  ASSERT_TRUE(RunUntil([&] { return robot_.pose().at.x_m > 3.2; }, 10'000));
  robot_.slips = 0.02;
  ASSERT_TRUE(AwaitEnd(drive, 30'000)) << "the time of the path is 5 s";
  EXPECT_EQ(CodeOf(drive), 105) << log_.back();
}

TEST_F(ControllerServerTest, FailsWhenTheBodyDoesNotMove) {
  StartServers();
  robot_.stuck = true;
  const std::size_t drive = Follow(PathOf({At(1, 2), At(3, 2)}));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(CodeOf(drive), 105);
  EXPECT_THAT(log_, Contains(HasSubstr("it is stuck, its wheels slip, or its odometry stands")));
  Run(100);
  ExpectStanding();
}

TEST_F(ControllerServerTest, StopsWithinHalfASecondWithoutOdometry) {
  StartServers();
  const std::size_t drive = StartDriving();
  robot_.odometry_silent = true;
  Run(500);
  ASSERT_TRUE(drives_.ends[drive]);
  EXPECT_EQ(CodeOf(drive), 102);
  EXPECT_THAT(log_, Contains(HasSubstr("no odometry on jetbot_0/odom for 0.4 s")));
  ExpectStanding();
}

TEST_F(ControllerServerTest, StopsWithoutAScan) {
  StartServers();
  const std::size_t drive = StartDriving();
  robot_.scan_silent = true;
  Run(1200);
  ASSERT_TRUE(drives_.ends[drive]);
  EXPECT_EQ(CodeOf(drive), 106);
  ExpectStanding();
}

TEST_F(ControllerServerTest, StandsAtOnceWhenItIsCancelled) {
  StartServers();
  const std::size_t drive = StartDriving();
  drives_.Cancel(drive);
  Run(100);
  ASSERT_TRUE(drives_.ends[drive]);
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kCanceled);
  ExpectStanding();
}

TEST_F(ControllerServerTest, StandsAtOnceInEveryStateButActive) {
  StartServers();
  for (const char* state : {"DeActive", "Protected", "LowPower", "OTA", "Error"}) {
    const std::size_t drive = Follow(PathOf({At(1, 2), At(6.5, 2)}));
    Run(1500);
    ASSERT_GT(robot_.commands(), 0);
    controller_->Permit(false, "it is in " + std::string(state));
    Run(50);
    ASSERT_TRUE(drives_.ends[drive]) << state;
    EXPECT_EQ(CodeOf(drive), 100) << state;
    ExpectStanding();
    const std::size_t refused = Follow(PathOf({At(1, 2), At(3, 2)}));
    Run(300);
    ASSERT_TRUE(drives_.ends[refused]);
    EXPECT_EQ(drives_.ends[refused]->end, GoalEnd::kRejected) << state;
    controller_->Permit(true, "");
  }
}

// It had waited in the kernel, and its client had long gone: the robot drove off.
TEST_F(ControllerServerTest, RejectsAGoalThatMayHaveWaitedWhileItsProcessCouldNotRun) {
  StartServers();
  network_.Pause(*controller_node_);
  Follow(PathOf({At(1, 2), At(3, 2)}));
  Run(9000);
  const int commands = robot_.commands();
  network_.Resume(*controller_node_);
  Run(1000);
  EXPECT_EQ(robot_.commands(), commands);
  EXPECT_THAT(log_, Contains(musher::testing::HasRefusal(ApplicationRefusal::kMayBeLate)));
  Run(2000);
  const std::size_t drive = Follow(PathOf({At(1, 2), At(3, 2)}));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
}

// The client of the late goal no longer follows the drive before it.
TEST_F(ControllerServerTest, EndsTheDriveThatARejectedLateGoalWasToReplace) {
  Duration& suspended = MakeSuspendable();
  StartServers();
  const std::size_t drive = StartDriving();
  suspended += std::chrono::seconds(9);
  const std::size_t late = Follow(PathOf({At(1, 2), At(3, 2)}));
  Run(100);
  ASSERT_TRUE(drives_.ends[late]);
  EXPECT_EQ(drives_.ends[late]->end, GoalEnd::kRejected);
  ASSERT_EQ(CodeOf(drive), 100);
  EXPECT_THAT(drives_.ends[drive]->result.error_msg,
              musher::testing::HasRefusal(ApplicationRefusal::kMayBeLate));
  ExpectStanding();
}

TEST_F(ControllerServerTest, EndsTheDriveThatWasUnderWayBeforeALongBreakOfItsProcess) {
  Duration& suspended = MakeSuspendable();
  StartServers();
  const std::size_t drive = StartDriving();
  suspended += std::chrono::seconds(50);
  Run(100);
  EXPECT_FALSE(drives_.ends[drive]);
  suspended += std::chrono::minutes(2);
  Run(100);
  EXPECT_EQ(CodeOf(drive), 100);
  EXPECT_THAT(log_,
              Contains(HasSubstr("the drive has ended: this server could not run for 120 s")));
  Run(1000);
  ExpectStanding();
  Run(2000);
  const std::size_t next = Follow(PathOf({At(robot_.pose().at.x_m, 2), At(6.5, 2)}));
  ASSERT_TRUE(AwaitEnd(next));
  EXPECT_EQ(drives_.ends[next]->end, GoalEnd::kSucceeded) << log_.back();
}

// The break does not end the drive that begins after it.
TEST_F(ControllerServerTest, DrivesAfterALongBreakInWhichNoGoalRan) {
  Duration& suspended = MakeSuspendable();
  StartServers();
  suspended += std::chrono::minutes(2);
  Run(3000);  // until goals are accepted again
  const std::size_t drive = Follow(PathOf({At(1, 2), At(3, 2)}));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
}

TEST_F(ControllerServerTest, StandsWhenTheWorldIsRestarted) {
  StartServers();
  const std::size_t drive = StartDriving();
  controller_->OnTimeJump("the time has jumped");
  Run(50);
  EXPECT_EQ(CodeOf(drive), 100);
  ExpectStanding();
}

TEST_F(ControllerServerTest, GoesOnWithoutAJerkAlongANewPathInItsDirection) {
  StartServers();
  const std::size_t first = StartDriving();
  robot_.ForgetHardest();
  const double x_m = robot_.pose().at.x_m;
  const std::size_t second = Follow(PathOf({At(x_m, 2), At(6, 2)}));
  double slowest = 9;
  for (int i = 0; i < 10; ++i) {
    Run(50);
    slowest = std::min(slowest, robot_.speed_m_s());
  }
  EXPECT_GT(slowest, 0.7) << "it does not stop";
  ASSERT_TRUE(AwaitEnd(second));
  EXPECT_EQ(CodeOf(first), 100);
  EXPECT_EQ(drives_.ends[second]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_LT(robot_.hardest_m_s2(), 2);
}

TEST_F(ControllerServerTest, BrakesWithinItsLimitsForANewPathElsewhere) {
  StartServers();
  const std::size_t first = StartDriving();
  robot_.ForgetHardest();
  const std::size_t second = Follow(PathOf({At(robot_.pose().at.x_m, 2), At(1, 3.2)}));
  ASSERT_TRUE(AwaitEnd(second));
  EXPECT_EQ(CodeOf(first), 100);
  EXPECT_EQ(drives_.ends[second]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_NEAR(robot_.pose().at.x_m, 1, 0.2);
  EXPECT_NEAR(robot_.pose().at.y_m, 3.2, 0.2);
  EXPECT_LT(robot_.hardest_m_s2(), 2);
}

TEST_F(ControllerServerTest, RefusesAGoalThatItCannotDrive) {
  StartServers();
  const auto expect = [&](const msg::FollowPath::Goal& goal, int code, const std::string& why) {
    const std::size_t drive = drives_.Send(goal);
    ASSERT_TRUE(AwaitEnd(drive, 1000)) << why;
    EXPECT_EQ(CodeOf(drive), code) << why;
    EXPECT_THAT(log_, Contains(HasSubstr(why)));
    log_.clear();
    Run(2100);
  };
  expect({.path = PathOf({At(1, 2), At(3, 2)}), .controller_id = "MPPI"}, 101,
         "expected '' or 'FollowPath'");
  msg::Path path = PathOf({At(1, 2), At(3, 2)});
  path.header.frame_id = "odom";
  expect({.path = path}, 102, "path: its frame is 'odom', expected 'map'");
  expect({.path = PathOf({})}, 103, "path: it has no pose");
  expect({.path = PathOf({At(1, 2), At(3, std::numeric_limits<double>::infinity())})}, 103,
         "path: pose 2 of 2: it has a number that is not finite");
  expect({.path = PathOf({At(5, 2), At(6, 2)})}, 103,
         "the path begins 4.00 m from the robot, at most 2.00 m");
  path = PathOf({At(1, 2), At(3, 2)});
  path.poses[1].pose.orientation = {0, 0, 0, 0};
  expect({.path = path}, 103, "path: pose 2 of 2: its orientation is (0, 0, 0, 0)");
}

TEST_F(ControllerServerTest, StandsAfterAPathInMotionThatItCannotDrive) {
  StartServers();
  const std::size_t first = StartDriving();
  const std::size_t second = Follow(PathOf({}));
  Run(100);
  EXPECT_EQ(CodeOf(first), 100);
  EXPECT_EQ(CodeOf(second), 103);
  ExpectStanding();
}

TEST_F(ControllerServerTest, ChecksThatTheRobotIsThere) {
  StartServers();
  EXPECT_TRUE(controller_->Check().result());
  robot_.scan_silent = true;
  Run(1500);
  const Result<> checked = controller_->Check().result();
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, 5309);
  EXPECT_THAT(checked.error().message, HasSubstr("jetbot_0: no scan on jetbot_0/scan for 1."));
}

class FlyerTest : public testing::NavigationRig {
 protected:
  FlyerTest() : NavigationRig({"jetbot_0", {{1, 2, 1}, 0}, false, 0.1}) {
    controller_config_.robots[0].flies = true;
    controller_config_.robots[0].differential = false;
    controller_config_.robots[0].radius_m = 0.15;
  }
};

TEST_F(FlyerTest, FliesAlongAPathInSpace) {
  StartServers();
  const std::size_t drive =
      Follow(PathOf({At(1, 2, 0, 1), At(3, 2, 0.5, 1.8), At(3, 3.2, 1, 0.6)}));
  bool aside = false;
  while (!drives_.ends[drive] && network_.Step()) {
    aside = aside || robot_.last_command().linear.y > 0.2;
  }
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_TRUE(aside);
  EXPECT_LT(Distance(robot_.pose().at, {3, 3.2, 0.6}), 0.2);
  EXPECT_NEAR(robot_.pose().yaw_rad, 1, 0.1);
}

TEST_F(FlyerTest, IsRefusedAPathThatBeginsFarAboveIt) {
  StartServers();
  const std::size_t drive = Follow(PathOf({At(1, 2, 0, 4), At(3, 2, 0, 4)}));
  ASSERT_TRUE(AwaitEnd(drive));
  EXPECT_EQ(CodeOf(drive), 103);
}

class ControllerOfAFlyer : public testing::NavigationRig {
 protected:
  ControllerOfAFlyer() : NavigationRig({"jetbot_0", {{1, 2, 1}, 0}, false}) {
    controller_config_.robots[0].flies = true;
    controller_config_.cloud_resolution_m = 0.2;
  }
  // The walls of the rooms up to a height of 2 m.
  msg::PointCloud2 Cloud() const {
    const CellMap& map = walls_.map();
    std::vector<float> values;
    for (std::size_t i = 0; i < map.count(); ++i) {
      if (map.blocked[i] == 0) continue;
      const Point corner = map.CentreOf(map.CellAt(i));
      for (int k = 0; k < 40; ++k) {
        const double x_m = corner.x_m + (k % 2 == 0 ? -0.1 : 0.1);
        const double y_m = corner.y_m + (k / 2 % 2 == 0 ? -0.1 : 0.1);
        for (const double value : {x_m, y_m, 0.1 + 0.2 * (k / 4)}) values.push_back(float(value));
      }
    }
    msg::PointCloud2 cloud;
    cloud.height = 1;
    cloud.point_step = 12;
    cloud.width = static_cast<std::uint32_t>(values.size() / 3);
    cloud.row_step = cloud.width * 12;
    for (std::uint32_t i = 0; i < 3; ++i) {
      cloud.fields.push_back({std::string(1, char('x' + i)), 4 * i, msg::PointField::kFloat32, 1});
    }
    cloud.data.resize(cloud.row_step);
    std::memcpy(cloud.data.data(), values.data(), cloud.data.size());
    return cloud;
  }
  // The time of a drive.
  double SecondsTo(double from_x_m, double to_x_m, double yaw_rad) {
    const Time begin = network_.now();
    const std::size_t drive =
        Follow(PathOf({At(from_x_m, 2, yaw_rad, 1), At(to_x_m, 2, yaw_rad, 1)}));
    EXPECT_TRUE(AwaitEnd(drive));
    EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
    return ToSeconds(network_.now() - begin);
  }
};

TEST_F(ControllerOfAFlyer, IsNotSlowedDownByWallsOfItsMap) {
  StartServers();
  const double seen_only_s = SecondsTo(1, 6.5, 0);
  const auto cloud = Must(transport::MakePublisher<msg::PointCloud2>(*peers_, "map_point_cloud",
                                                                     transport::kLatchedQos));
  EXPECT_TRUE(cloud->Publish(Cloud()));
  Run(1000);
  const double known_s = SecondsTo(robot_.pose().at.x_m, 1, 0);
  EXPECT_LT(known_s, seen_only_s - 0.3);
}

// What the scan sees counts for as high as the room, so the way is beside it, and there is room.
TEST_F(ControllerOfAFlyer, PassesAPersonInItsRoom) {
  planner_config_.robots[0].flies = true;
  planner_config_.robots[0].radius_m = controller_config_.robots[0].radius_m = 0.15;
  planner_config_.ceiling_m = 2;
  StartServers();
  const auto cloud = Must(transport::MakePublisher<msg::PointCloud2>(*peers_, "map_point_cloud",
                                                                     transport::kLatchedQos));
  msg::PointCloud2 walls = Cloud();
  walls.header.frame_id = "map";
  EXPECT_TRUE(cloud->Publish(walls));
  Run(1000);
  const testing::Disc person{{2.3, 2, 0}, 0.25};
  robot_.discs = {person};
  double nearest_m = 10;
  const auto watch = peers_->loop().Every(Milliseconds(10), [&] {
    const Point& at = robot_.pose().at;
    nearest_m = std::min(nearest_m, std::hypot(at.x_m - 2.3, at.y_m - 2) - person.radius_m - 0.15);
  });
  bool arrived = false;
  for (int tries = 0; tries < 5 && !arrived; ++tries) {
    const auto plan = Plan({.goal = At(6.5, 2, 0, 1)});
    ASSERT_EQ(plan.end, GoalEnd::kSucceeded) << plan.result.error_msg;
    const std::size_t drive = Follow(plan.result.path);
    ASSERT_TRUE(AwaitEnd(drive));
    arrived = drives_.ends[drive]->end == GoalEnd::kSucceeded;
    EXPECT_TRUE(arrived || CodeOf(drive) == 104) << drives_.ends[drive]->result.error_msg;
  }
  EXPECT_TRUE(arrived);
  EXPECT_GT(nearest_m, 0);
}

}  // namespace musher::navigation::controller_server_test
