// A robot behind its topics.

#include <algorithm>

#include "musher/messages/nav_msgs/occupancy_grid.hpp"
#include "musher/messages/tf2_msgs/tf_message.hpp"
#include "musher/messages/yaw.hpp"
#include "musher/modules/skills/robot/battery_presence.hpp"
#include "musher/navigation/planner/cell_map.hpp"
#include "musher/test/modules/skills/robot_on_network.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::skills::ros_robot_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST_F(ARosRobot, KnowsItsPoseAsLongAsItsOdometryIsRecent) {
  EXPECT_FALSE(robot_.pose());
  Stand(2, M_PI / 2);
  ASSERT_TRUE(robot_.pose());
  EXPECT_EQ(robot_.pose()->at.x_m, 2);
  EXPECT_NEAR(robot_.velocity().y_m_s, 0.5, 1e-9);
  Run(600);
  EXPECT_FALSE(robot_.pose());
  EXPECT_EQ(robot_.velocity(), navigation::Velocity{});
}

TEST_F(ARosRobot, KnowsThePathThatItHasComeUntilItsOdometryJumps) {
  EXPECT_THAT(robot_.travelled(), IsEmpty());
  for (int i = 0; i <= 10; ++i) Stand(0.1 * i, 0);
  const navigation::Path back = robot_.travelled();
  ASSERT_THAT(back, SizeIs(11));
  EXPECT_NEAR(back.front().at.x_m, 1, 1e-9);
  EXPECT_NEAR(back.back().at.x_m, 0, 1e-9);
  ASSERT_TRUE(robot_.odometry());
  EXPECT_NEAR(robot_.odometry()->at.x_m, 1, 1e-9);
  Stand(4, 0);
  EXPECT_THAT(robot_.travelled(), SizeIs(1));
}

TEST_F(ARosRobot, PublishesItsVelocityTwentyTimesASecondUntilItStops) {
  See(9);
  Run(20);
  robot_.SetVelocity({0.5, 0, 0, 0.25});
  sees_m_ = 9;
  Run(1000);
  EXPECT_NEAR(double(peers_->commands.size()), 31, 3) << "and with each scan";
  EXPECT_EQ(peers_->commands.back().linear.x, 0.5);
  EXPECT_EQ(peers_->commands.back().angular.z, 0.25);
  robot_.StopMotion();
  Run(50);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  const std::size_t count = peers_->commands.size();
  Run(1000);
  EXPECT_EQ(peers_->commands.size(), count);
}

TEST_F(ARosRobot, LetsNoCommandLeadItIntoWhatItsScanSees) {
  sees_m_ = 9;
  Run(200);
  robot_.SetVelocity({0.5, 0, 0, 0});
  Run(200);
  EXPECT_EQ(peers_->commands.back().linear.x, 0.5);
  EXPECT_EQ(robot_.HeldBy(), "");
  See(0.3);
  Run(10);
  EXPECT_LT(peers_->commands.back().linear.x, 0.3) << "at once";
  sees_m_ = 0.24;
  Run(300);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  EXPECT_EQ(robot_.HeldBy(), "an obstacle 0.24 m away, straight ahead, stops it");
  robot_.SetVelocity({-0.5, 0, 0, 0});
  Run(100);
  EXPECT_EQ(peers_->commands.back().linear.x, -0.5);
  sees_m_.reset();
  Run(700);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{}) << "it does not move blindly";
  EXPECT_THAT(robot_.HeldBy(), HasSubstr("no recent scan on r/scan"));
}

TEST_F(ARosRobot, KnowsWhichPlacesItsScanCovers) {
  EXPECT_FALSE(robot_.ScanCovers({1, 0, 0}));
  See(9);
  Run(20);
  for (const navigation::Point at : {navigation::Point{1, 0, 0}, {-1, 0, 0}, {0, -1, 0}}) {
    EXPECT_TRUE(robot_.ScanCovers(at));
  }
  Run(600);
  EXPECT_FALSE(robot_.ScanCovers({1, 0, 0})) << "it is not recent";
  msg::LaserScan ahead;  // 180 degrees
  ahead.range_max = 10;
  ahead.angle_min = static_cast<float>(-M_PI / 2);
  ahead.angle_increment = static_cast<float>(M_PI / 180);
  ahead.ranges.assign(181, std::numeric_limits<float>::infinity());
  EXPECT_TRUE(peers_->scan->Publish(ahead));
  Run(20);
  EXPECT_TRUE(robot_.ScanCovers({1, 0, 0}));
  EXPECT_TRUE(robot_.ScanCovers({1, -0.9, 0}));
  EXPECT_FALSE(robot_.ScanCovers({-1, 0, 0}));
  EXPECT_FALSE(robot_.ScanCovers({-0.2, 0.3, 0}));
}

TEST_F(ARosRobot, SendsNothingBesideADrive) {
  sees_m_ = 9;
  Run(200);
  robot_.SetVelocity({});
  Run(200);
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(50);
  const std::size_t count = peers_->commands.size();
  Run(500);
  EXPECT_EQ(peers_->commands.size(), count) << "the controller has the base";
}

TEST_F(ARosRobot, StopsWhenItIsCommandedAndDoesNotMove) {
  sees_m_ = 9;
  Run(200);
  robot_.SetVelocity({0.5, 0, 0, 0});
  for (int i = 0; i < 20; ++i) {
    Stand(1, 0);
    Run(80);
  }
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  EXPECT_THAT(robot_.HeldBy(), HasSubstr("its odometry does not change at all: it is stuck"));
  robot_.StopMotion();
  Run(50);
  EXPECT_EQ(robot_.HeldBy(), "");
  robot_.SetVelocity({-0.5, 0, 0, 0});
  Run(50);
  EXPECT_EQ(peers_->commands.back().linear.x, -0.5) << "the next skill may try";
}

// follow_line, grasp and the other skills that command the base themselves believed any pose.
TEST_F(ARosRobot, StopsWhenItsPoseJumpsFartherThanABodyCan) {
  sees_m_ = 9;
  Run(200);
  robot_.SetVelocity({0.3, 0, 0, 0});
  for (int i = 0; i < 5; ++i) {
    Stand(1 + 0.03 * i, 0);
    Run(80);
  }
  EXPECT_EQ(peers_->commands.back().linear.x, 0.3);
  Stand(9, 0);
  Run(80);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  EXPECT_THAT(robot_.HeldBy(), HasSubstr("the pose has jumped by"));
  Stand(9.1, 0);
  Run(80);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{}) << "until the skill has ended";
  robot_.StopMotion();
  EXPECT_EQ(robot_.HeldBy(), "");
}

TEST_F(ARosRobot, IsTeleoperatedAgainAfterAJumpOnceThePersonReleasesTheStick) {
  sees_m_ = 9;
  Run(200);
  const auto drive = [this](double x_m_s, int times) {
    for (int i = 0; i < times; ++i) {
      msg::Twist twist;
      twist.linear.x = x_m_s;
      EXPECT_TRUE(peers_->teleop->Publish(twist));
      Run(80);
    }
  };
  Stand(1, 0);
  drive(0.3, 2);
  Stand(9, 0);
  drive(0.3, 2);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  Stand(9, 0);
  drive(0, 1);
  drive(0.3, 2);
  EXPECT_EQ(peers_->commands.back().linear.x, 0.3);
}

// Each turn of a body that is faster than the usual limit was a jump of its direction.
class ARosRobotThatTurnsFast : public ARosRobot {
 protected:
  static SkillsConfig Fast() {
    SkillsConfig config = ConfigOfR();
    config.yaw_rad_s = 6;
    return config;
  }
  ARosRobotThatTurnsFast() : ARosRobot(Fast()) {}
};

TEST_F(ARosRobotThatTurnsFast, IsTeleoperatedAsFastAsItsConfigSays) {
  sees_m_ = 9;
  Run(200);
  msg::Twist twist;
  twist.angular.z = 5;
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(peers_->teleop->Publish(twist));
    Stand(1, navigation::Wrapped(0.25 * i));
    Run(50);
    EXPECT_EQ(robot_.HeldBy(), "");
  }
  EXPECT_EQ(peers_->commands.back().angular.z, 5);
}

TEST_F(ARosRobot, HasTheMapWhileASkillAsksForIt) {
  auto* maps = peers_->endpoints.Advertise<msg::OccupancyGrid>("map", transport::kLatchedQos);
  msg::OccupancyGrid grid;
  grid.header.frame_id = "map";
  grid.info.resolution = 0.5F;
  grid.info.width = 2;
  grid.info.height = 1;
  grid.info.origin.orientation.w = 1;
  grid.info.origin.position.x = 3;
  grid.data = {100, -1};
  EXPECT_TRUE(maps->Publish(grid));
  Run(100);
  EXPECT_TRUE(robot_.map().awaited);
  EXPECT_EQ(robot_.map().cells, nullptr);
  Run(500);
  const auto cells = robot_.map().cells;
  ASSERT_NE(cells, nullptr);
  EXPECT_EQ(cells->CentreOf({0, 0, 0}).x_m, 3.25);
  EXPECT_THAT(cells->blocked, ElementsAre(1, 0)) << "what is unknown is to be explored";
  ASSERT_NE(robot_.map().known, nullptr);
  EXPECT_THAT(robot_.map().known->blocked, ElementsAre(1, 1));
  grid.data.pop_back();
  EXPECT_TRUE(maps->Publish(grid));
  Run(500);
  EXPECT_EQ(robot_.map().cells, cells) << "the next one has other sizes";
  Run(6000);
  EXPECT_EQ(robot_.map().cells, nullptr);
  EXPECT_EQ(robot_.map().known, nullptr);
}

TEST_F(ARosRobot, DoesNotWaitLongForAMapThatDoesNotCome) {
  EXPECT_TRUE(robot_.map().awaited);
  Run(2100);
  EXPECT_FALSE(robot_.map().awaited);
}

TEST_F(ARosRobot, ClearsTheMemoryOfPlannerAndController) {
  EXPECT_TRUE(ResultOf(robot_.ClearMemory()));
  EXPECT_THAT(peers_->cleared, ::testing::UnorderedElementsAre("r/clear_planner_memory",
                                                               "r/clear_controller_memory"));
  peers_->clears = false;
  EXPECT_EQ(ResultOf(robot_.ClearMemory()).error().message, "it is busy");
  peers_.reset();
  EXPECT_THAT(ResultOf(robot_.ClearMemory()).error().message,
              HasSubstr("the memory is not cleared: "));
}

TEST_F(ARosRobot, TakesOdometryWhoseStampsStandForNone) {
  msg::Odometry odometry;
  odometry.pose.pose.orientation.w = 1;
  odometry.header.stamp = {7, 0};
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(peers_->odometry->Publish(odometry));
    Run(100);
  }
  EXPECT_FALSE(robot_.pose());
}

// Its pose went back with them.
TEST_F(ARosRobot, TakesOdometryWhoseStampsGoBackForNone) {
  for (const Duration step : {Milliseconds(20), Milliseconds(2000)}) {
    msg::Odometry odometry;
    odometry.pose.pose.orientation.w = 1;
    for (int i = 0; i < 20; ++i) {
      odometry.header.stamp = msg::ToStamp(std::chrono::seconds(500) - i * step);
      EXPECT_TRUE(peers_->odometry->Publish(odometry));
      Run(100);
    }
    EXPECT_FALSE(robot_.pose());
    EXPECT_THAT(robot_.WhyNoPose(), HasSubstr("its stamps do not go on"));
  }
}

TEST_F(ARosRobot, ExecutesTeleoperationThroughTheGateWhileNoSkillMovesIt) {
  sees_m_ = 9;
  Run(200);
  msg::Twist twist;
  twist.linear.x = 0.6;
  EXPECT_TRUE(peers_->teleop->Publish(twist));
  Run(100);
  EXPECT_EQ(peers_->commands.back().linear.x, 0.6);
  See(0.24);
  Run(20);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  Run(700);
  const std::size_t count = peers_->commands.size();
  EXPECT_EQ(peers_->commands.back(), msg::Twist{}) << "a person who is silent drives no more";
  Run(300);
  EXPECT_EQ(peers_->commands.size(), count);
  robot_.SetVelocity({0.2, 0, 0, 0});
  EXPECT_TRUE(peers_->teleop->Publish(twist));
  Run(100);
  EXPECT_EQ(peers_->commands.back().linear.x, 0.2) << "the skill has the base";
}

// StandStill() sent one 0, and what a person commanded in the next half second began to move it
// again.
TEST_F(ARosRobot, IsNotMovedByAPersonFromAStopUntilItIsSteppedInActiveAgain) {
  sees_m_ = 9;
  Run(200);
  msg::Twist twist;
  twist.linear.x = 0.5;
  const auto teleoperate = [&](bool active) {
    for (int i = 0; i < 20; ++i) {
      EXPECT_TRUE(peers_->teleop->Publish(twist));
      if (active) {
        Run(50);
      } else {
        See(9);
        network_.RunFor(Milliseconds(50));
      }
    }
  };
  teleoperate(true);
  EXPECT_EQ(peers_->commands.back().linear.x, 0.5);
  robot_.StandStill();
  network_.RunFor(Milliseconds(10));
  ASSERT_EQ(peers_->commands.back(), msg::Twist{});
  const std::size_t count = peers_->commands.size();
  teleoperate(false);
  EXPECT_EQ(peers_->commands.size(), count) << "as at an emergency stop: no step follows";
  teleoperate(true);
  EXPECT_EQ(peers_->commands.back().linear.x, 0.5) << "in Active again";
}

// Of ROS 2's localisations: odometry in `odom`, which a transform places in the map.
class ARosRobotWithOdometryInAFrameOfItsOwn : public ARosRobot {
 protected:
  ARosRobotWithOdometryInAFrameOfItsOwn()
      : tf_(peers_->endpoints.Advertise<msg::TfMessage>("/tf")),
        fixed_(peers_->endpoints.Advertise<msg::TfMessage>("/tf_static", transport::kLatchedQos)) {
    Run(500);
  }
  static msg::TfMessage Transform(const std::string& parent, const std::string& child,
                                  const navigation::Pose& pose) {
    msg::TfMessage message;
    message.transforms.resize(1);
    message.transforms[0].header.frame_id = parent;
    message.transforms[0].child_frame_id = child;
    message.transforms[0].transform.translation = {pose.at.x_m, pose.at.y_m, pose.at.z_m};
    message.transforms[0].transform.rotation = msg::FromYaw(pose.yaw_rad);
    return message;
  }
  void Localise(const navigation::Pose& odom_in_map) {
    EXPECT_TRUE(tf_->Publish(Transform("map", "odom", odom_in_map)));
    Run(20);
  }

  transport::Publisher<msg::TfMessage>* const tf_;
  transport::Publisher<msg::TfMessage>* const fixed_;
};

TEST_F(ARosRobotWithOdometryInAFrameOfItsOwn, HasNoPoseInTheMapBeforeATransformIsKnown) {
  Stand(2, 0, "odom");
  EXPECT_FALSE(robot_.pose());
  EXPECT_EQ(robot_.velocity(), navigation::Velocity{});
  EXPECT_EQ(robot_.WhyNoPose(),
            "No pose of r in the map (r/odom: no transform from map to odom: odom has no known "
            "parent)");
  EXPECT_EQ(robot_.Look().odometry,
            "no pose in the map: r/odom: no transform from map to odom: odom has no known parent");
  Run(600);
  EXPECT_EQ(robot_.WhyNoPose(), "No odometry of r");
  Stand(2, 0, "map");
  EXPECT_TRUE(robot_.pose());
}

TEST_F(ARosRobotWithOdometryInAFrameOfItsOwn, KnowsWhichFramesLieInEachOther) {
  EXPECT_FALSE(robot_.HasTransform("odom", "base_link")) << "no odometry";
  Stand(2, 0, "odom");
  EXPECT_TRUE(robot_.HasTransform("odom", "base_link"));
  EXPECT_FALSE(robot_.HasTransform("map", "base_link"));
  EXPECT_FALSE(robot_.HasTransform("odom", "laser"));
  EXPECT_TRUE(fixed_->Publish(Transform("base_link", "laser", {})));
  Localise({{1, 0, 0}, 0});
  Stand(2, 0, "odom");
  EXPECT_TRUE(robot_.HasTransform("map", "odom"));
  EXPECT_TRUE(robot_.HasTransform("map", "base_link"));
  EXPECT_TRUE(robot_.HasTransform("map", "laser"));
  EXPECT_FALSE(robot_.HasTransform("laser", "map")) << "only along the parents";
  Run(1500);
  EXPECT_FALSE(robot_.HasTransform("map", "base_link")) << "neither is recent";
}
TEST_F(ARosRobotWithOdometryInAFrameOfItsOwn, IsWhereTheTransformPlacesItInTheMap) {
  Localise({{3, -1, 0}, M_PI / 2});
  Stand(2, 0, "odom");
  See(2);
  Run(20);
  ASSERT_TRUE(robot_.pose());
  EXPECT_NEAR(robot_.pose()->at.x_m, 3, 1e-9);
  EXPECT_NEAR(robot_.pose()->at.y_m, 1, 1e-9);
  EXPECT_NEAR(robot_.pose()->yaw_rad, M_PI / 2, 1e-9);
  EXPECT_NEAR(robot_.velocity().y_m_s, 0.5, 1e-9);
  ASSERT_THAT(robot_.obstacles(), SizeIs(1));
  EXPECT_NEAR(robot_.obstacles()[0].x_m, 3, 1e-6);
  EXPECT_NEAR(robot_.obstacles()[0].y_m, 3, 1e-6);
}

TEST_F(ARosRobotWithOdometryInAFrameOfItsOwn, LosesItsPoseInTheMapWhenTheTransformIsLate) {
  Localise({{3, -1, 0}, 0});
  for (int i = 0; i < 18; ++i) {
    Stand(2, 0, "odom");
    Run(80);
  }
  EXPECT_TRUE(robot_.WhyNoPose().starts_with("No pose of r in the map"));
  Stand(2, 0, "odom");
  EXPECT_FALSE(robot_.pose());
  EXPECT_THAT(robot_.WhyNoPose(), HasSubstr("that of odom in map is 1."));
  Localise({{3, -1, 0}, 0});
  Stand(2, 0, "odom");
  EXPECT_TRUE(robot_.pose()) << "the localisation is there again";
}

TEST_F(ARosRobotWithOdometryInAFrameOfItsOwn, TracksATargetWhereTheTransformPlacesItOrSaysWhyNot) {
  const std::string topic = "/target_0/odom";
  EXPECT_FALSE(robot_.PoseOf(topic));  // subscribes
  Run(500);
  msg::Odometry target;
  target.header.frame_id = "odom";
  target.pose.pose.position.x = 7;
  EXPECT_TRUE(peers_->target->Publish(target));
  Run(50);
  EXPECT_FALSE(robot_.PoseOf(topic));
  EXPECT_EQ(robot_.PosesOf(topic), 0U);
  EXPECT_THAT(robot_.WhyNoPoseOf(topic), HasSubstr("no transform from map to odom"));
  Localise({{3, -1, 0}, 0});
  EXPECT_TRUE(peers_->target->Publish(target));
  Run(50);
  ASSERT_TRUE(robot_.PoseOf(topic));
  EXPECT_NEAR(robot_.PoseOf(topic)->at.x_m, 10, 1e-9);
}

TEST_F(ARosRobotWithOdometryInAFrameOfItsOwn, SeesObjectsWhereTheTransformPlacesThemOrSaysWhyNot) {
  msg::ObjectStates states;
  states.header.frame_id = "odom";
  states.objects.resize(1);
  states.objects[0].name = "cup";
  states.objects[0].pose.position.x = 7;
  states.objects[0].pose.orientation.w = 1;
  EXPECT_TRUE(peers_->objects->Publish(states));
  Run(50);
  EXPECT_FALSE(robot_.HasObjects());
  EXPECT_FALSE(robot_.Detect());
  EXPECT_THAT(robot_.WhyNothingSeen(), HasSubstr("(world/objects: no transform from map to odom"));
  EXPECT_THAT(robot_.Look().others, Contains(HasSubstr("place in the map for world/objects")));
  Localise({{3, -1, 0}, M_PI / 2});
  EXPECT_TRUE(peers_->objects->Publish(states));
  Run(50);
  ASSERT_THAT(robot_.objects(), SizeIs(1));
  EXPECT_NEAR(robot_.objects()[0].pose.at.x_m, 3, 1e-9);
  EXPECT_NEAR(robot_.objects()[0].pose.at.y_m, 6, 1e-9);
}

TEST_F(ARosRobotWithOdometryInAFrameOfItsOwn, DrivesAPathWhereTheTransformPlacesItOrRefusesIt) {
  msg::ComputePathToPose::Result result;
  result.path = ToMessage(navigation::Path{{{0, 0, 0}, 0}, {{2, 0, 0}, 0}}, {});
  result.path.header.frame_id = "odom";
  const auto unplaced = robot_.ComputePath({{3, 1, 0}, 0}, navigation::Pose{});
  Run(100);
  peers_->plans[0].Succeed(result);
  EXPECT_THAT(ResultOf(unplaced).error().message,
              HasSubstr("the planner's path is not used: no transform from map to odom"));
  Localise({{3, -1, 0}, M_PI / 2});
  const auto placed = robot_.ComputePath({{3, 1, 0}, 0}, navigation::Pose{});
  Run(100);
  peers_->plans[1].Succeed(result);
  const auto path = ResultOf(placed);
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_NEAR(path.value().back().at.x_m, 3, 1e-9);
  EXPECT_NEAR(path.value().back().at.y_m, 1, 1e-9);
}

TEST_F(ARosRobotWithOdometryInAFrameOfItsOwn, SeesFromWhereATransformPutsItsScanner) {
  EXPECT_TRUE(fixed_->Publish(Transform("base_link", "laser", {{-0.1, 0, 0.2}, M_PI})));
  Run(100);
  Stand(0, 0, "map");
  msg::LaserScan scan;
  scan.header.frame_id = "laser";
  scan.range_max = 10;
  scan.ranges = {2};
  EXPECT_TRUE(peers_->scan->Publish(scan));
  Run(20);
  ASSERT_THAT(robot_.obstacles(), SizeIs(1));
  EXPECT_NEAR(robot_.obstacles()[0].x_m, -2.1, 1e-6);
}

class ARosFlyer : public ARosRobot {
 protected:
  ARosFlyer() : ARosRobot(FlyerConfig()) {}
  static SkillsConfig FlyerConfig() {
    SkillsConfig config = ConfigOfR();
    config.flies = true;
    config.gate.scanners.clear();
    config.gate.blind_m_s = navigation::kFlyerBlindMS;
    config.low_battery_percent = 10;
    return config;
  }
  void ReportOnce(float share, std::uint8_t status = msg::BatteryState::kStatusDischarging,
                  bool present = true) {
    msg::BatteryState battery;
    battery.percentage = share;
    battery.power_supply_status = status;
    battery.present = present;
    EXPECT_TRUE(peers_->battery->Publish(battery));
    Run(20);
  }
  // Ten times in 5 s, in the air.
  void ReportBattery(float share, std::uint8_t status = msg::BatteryState::kStatusDischarging,
                     bool present = true) {
    for (int i = 0; i < 10; ++i) {
      ReportOnce(share, status, present);
      Fly(0.48);
    }
  }
  // In a wind along x, for so long; returns where it is.
  double Fly(double seconds) {
    for (int i = 0; i < 50 * seconds; ++i) {
      const bool recent = !peers_->commands.empty();
      if (!stands_) x_m_ += 0.02 * ((recent ? peers_->commands.back().linear.x : 0) + 0.1);
      msg::Odometry odometry;
      odometry.header.frame_id = frame_;
      odometry.pose.pose = ToMessage(navigation::Pose{{x_m_, 0, z_m_}, 0}, {}).pose;
      EXPECT_TRUE(peers_->odometry->Publish(odometry));
      Run(20);
    }
    return x_m_;
  }
  double x_m_ = 0, z_m_ = 1;
  bool stands_ = false;  // on something: the wind does not carry it
  std::string frame_;
};

// The wind is 0.1 m/s: without a hold it is carried 2 m in 20 s.
TEST_F(ARosFlyer, KeepsItsPlaceAfterASkillHasEnded) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  const double place_m = Fly(2);
  EXPECT_NEAR(Fly(20), place_m, 0.2);
}

TEST_F(ARosFlyer, KeepsItsPlaceAlsoInAPauseAndAtAStop) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StandStill();
  const double place_m = Fly(2);
  EXPECT_NEAR(Fly(20), place_m, 0.2);
  robot_.SetVelocity({-0.5, 0, 0, 0});
  EXPECT_LT(Fly(2), place_m - 0.5) << "a skill moves it again";
  robot_.StopMotion();
  robot_.NoteLanding();
  Run(300);
  const std::size_t count = peers_->commands.size();
  Fly(1);
  EXPECT_EQ(peers_->commands.size(), count) << "it has landed";
}

TEST_F(ARosFlyer, KeepsItsPlaceAlsoWhileItHasNoneInTheMap) {
  frame_ = "odom";
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  const double place_m = Fly(2);
  EXPECT_NEAR(Fly(20), place_m, 0.2);
  EXPECT_FALSE(robot_.pose());
}

TEST_F(ARosFlyer, IsNotHeldAgainstADriveOfAnotherClient) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  Fly(2);
  const auto client =
      Must(transport::MakeActionClient<msg::FollowPath>(*world_, "dog/r/follow_path"));
  Run(500);
  client->SendGoal({}, Milliseconds(1000), {});
  Run(300);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  EXPECT_TRUE(robot_.Drives());
  const std::size_t count = peers_->commands.size();
  Fly(3);
  EXPECT_EQ(peers_->commands.size(), count) << "its base is the controller's";
  peers_->drives[0].Succeed({});
  const double place_m = Fly(2);
  EXPECT_FALSE(robot_.Drives());
  EXPECT_NEAR(Fly(20), place_m, 0.2) << "held at its new place";
}

// A program that is none of Musher's, such as a person's own teleop.
TEST_F(ARosFlyer, IsLeftToAnotherProgramThatLandsIt) {
  auto* others = peers_->endpoints.Advertise<msg::Twist>("r/cmd_vel");
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  Fly(2);
  Run(500);
  msg::Twist down;
  down.linear.z = -0.3;
  const auto ours = [&] {
    return std::ranges::count_if(peers_->commands, [&](const msg::Twist& one) {
      return one != down && one != msg::Twist{};
    });
  };
  EXPECT_TRUE(others->Publish(down));
  Fly(0.2);
  const auto before = ours();
  for (; z_m_ > 0.75; z_m_ -= 0.03) {
    EXPECT_TRUE(others->Publish(down));
    Fly(0.1);
  }
  EXPECT_TRUE(others->Publish(msg::Twist{}));
  stands_ = true;  // on a table of that height
  Fly(20);
  EXPECT_EQ(ours(), before) << "and it climbs nowhere afterwards";
  EXPECT_THAT(lines_, ElementsAre("r is not held at its place any more: another program commands "
                                  "it; it is held again if that leaves it in the air"));
  stands_ = false;
  robot_.SetVelocity({-0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  const double place_m = Fly(3);
  EXPECT_NEAR(Fly(20), place_m, 0.2) << "a skill has moved it";
}

// The wind carried it away once the commands had ended, whether a skill had moved it before or not.
TEST_F(ARosFlyer, KeepsItsPlaceAfterTheCommandsOfAnotherProgramHaveEnded) {
  auto* others = peers_->endpoints.Advertise<msg::Twist>("r/cmd_vel");
  Run(500);
  msg::Twist ahead;
  ahead.linear.x = 0.5;
  for (const bool used : {false, true}) {
    if (used) {
      robot_.SetVelocity({-0.5, 0, 0, 0});
      Fly(1);
      robot_.StopMotion();
      Fly(2);
    }
    for (int i = 0; i < 20; ++i) {
      EXPECT_TRUE(others->Publish(ahead));
      Fly(0.1);
    }
    EXPECT_TRUE(others->Publish(msg::Twist{}));
    const double place_m = Fly(3);
    EXPECT_NEAR(Fly(20), place_m, 0.2) << "used " << used;
  }
}

// As after a kill of its process: the wind had it until a skill or a drive moved it.
TEST_F(ARosFlyer, KeepsItsPlaceAfterARestartOfItsProcessInTheAir) {
  const TempFolder folder;
  const auto restart = [&] {
    endpoints_ = std::make_unique<transport::Endpoints>(*body_, "dog");
    robot_.Open(*endpoints_, "dog", {}, folder / "r_flight.toml");
    Run(500);
  };
  restart();
  const std::size_t count = peers_->commands.size();
  Fly(3);
  EXPECT_EQ(peers_->commands.size(), count) << "no skill has moved it: it may be in a hand";
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(2);
  restart();
  const double place_m = Fly(2);
  EXPECT_NEAR(Fly(20), place_m, 0.2);
  robot_.NoteLanding();
  Fly(1);
  restart();
  const std::size_t landed = peers_->commands.size();
  Fly(3);
  EXPECT_EQ(peers_->commands.size(), landed);
}

TEST_F(ARosFlyer, IsLeftWhereAPersonHasPutItDown) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  Fly(2);
  for (; z_m_ > 0.3; z_m_ -= 0.05) Fly(0.1);
  Fly(0.5);
  const std::size_t count = peers_->commands.size();
  Fly(60);
  EXPECT_EQ(peers_->commands.size(), count);
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("lower than its place against its commands")));
}

TEST_F(ARosFlyer, LandsInEveryStateWhenItsBatteryIsLow) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StandStill();  // as at an emergency stop
  Fly(2);
  ReportBattery(0.11F);
  EXPECT_EQ(robot_.LowBattery(), "");
  Fly(1);
  EXPECT_NEAR(peers_->commands.back().linear.z, 0, 0.05);
  ReportBattery(0.09F);
  EXPECT_EQ(robot_.LowBattery(), "the battery of r is at 9 %, its limit is 10 %");
  Fly(1);
  EXPECT_LT(peers_->commands.back().linear.z, -0.1);
  ReportBattery(std::numeric_limits<float>::quiet_NaN());
  ReportBattery(0.11F);
  EXPECT_NE(robot_.LowBattery(), "") << "it does not end with the noise of a sensor";
  ReportBattery(0.09F, msg::BatteryState::kStatusCharging);
  EXPECT_EQ(robot_.LowBattery(), "");
}

TEST_F(ARosFlyer, EndsItsLandingOnTheGroundWhileItsBatteryReports) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  Fly(1);
  ReportBattery(0.05F);
  z_m_ = 0.02;
  ReportBattery(0.05F);
  const std::size_t count = peers_->commands.size();
  ReportBattery(0.05F);
  EXPECT_EQ(peers_->commands.size(), count) << "it stands";
  ReportBattery(0.05F, msg::BatteryState::kStatusCharging);
  z_m_ = 0.5;
  ReportBattery(0.2F, msg::BatteryState::kStatusCharging);
  EXPECT_EQ(peers_->commands.size(), count) << "it is carried";
}

TEST_F(ARosFlyer, TakesNoSingleMessageOfItsBatteryForItsLevel) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  for (int i = 0; i < 5; ++i) {
    ReportBattery(0.5F);
    ReportOnce(0.01F);
    EXPECT_EQ(robot_.LowBattery(), "");
  }
  ReportBattery(0.05F);
  ASSERT_NE(robot_.LowBattery(), "");
  ReportOnce(0.9F);
  EXPECT_NE(robot_.LowBattery(), "");
  ReportBattery(0.05F);
  ReportOnce(0.05F, msg::BatteryState::kStatusCharging);
  EXPECT_NE(robot_.LowBattery(), "");
}

// The full one of another robot, in turn with its own, kept it in the air.
TEST_F(ARosFlyer, LandsWhenTheLowerOfTwoBatteriesIsLow) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  const auto& other =
      peers_->endpoints.Advertise<msg::BatteryState>("r/battery", transport::kSensorDataQos);
  msg::BatteryState full;
  full.percentage = 0.8F;
  full.present = true;
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(other->Publish(full));
    ReportOnce(0.05F);
    Fly(0.48);
  }
  EXPECT_NE(robot_.LowBattery(), "");
  EXPECT_THAT(lines_, Contains(HasSubstr("has two publishers: the lower level counts")));
}

TEST_F(ARosFlyer, KnowsTheLevelOfItsBatteryAndWhetherItCharges) {
  EXPECT_FALSE(robot_.battery());
  msg::BatteryState battery;
  battery.percentage = 0.6F;
  battery.voltage = std::numeric_limits<float>::quiet_NaN();
  battery.power_supply_status = msg::BatteryState::kStatusFull;
  battery.present = true;
  EXPECT_TRUE(peers_->battery->Publish(battery));
  Run(20);
  ASSERT_TRUE(robot_.battery());
  EXPECT_NEAR(robot_.battery()->share, 0.6, 1e-6);
  EXPECT_FALSE(robot_.battery()->voltage_v);
  EXPECT_FALSE(robot_.battery()->charges) << "it is full";
  battery.voltage = 11.5;
  battery.power_supply_status = msg::BatteryState::kStatusCharging;
  EXPECT_TRUE(peers_->battery->Publish(battery));
  Run(20);
  EXPECT_TRUE(robot_.battery()->charges);
  EXPECT_NEAR(robot_.battery()->voltage_v.value_or(0), 11.5, 1e-6);
}
TEST_F(ARosFlyer, ForgetsTheBatteryOfAPublisherThatIsGone) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  auto other = transport::MakePublisher<msg::BatteryState>(peers_->node, "dog/r/battery",
                                                           transport::kLatchedQos)
                   .value();
  msg::BatteryState low;
  low.percentage = 0.05F;
  low.present = true;
  Run(100);
  EXPECT_TRUE(other->Publish(low));
  ReportBattery(0.8F);
  ASSERT_NE(robot_.LowBattery(), "");
  other.reset();
  ReportBattery(0.8F);
  EXPECT_EQ(robot_.LowBattery(), "");
}

TEST_F(ARosFlyer, RefusesLevelsOfNoBatteryAndThoseThatNoBatteryHas) {
  for (const float share : {-1.0F, -0.01F, 87.0F, std::numeric_limits<float>::infinity()}) {
    ReportBattery(share);
    EXPECT_EQ(robot_.LowBattery(), "") << share;
  }
  ReportBattery(0, msg::BatteryState::kStatusUnknown, false);
  EXPECT_EQ(robot_.LowBattery(), "");
  ReportBattery(0.05F);
  ASSERT_NE(robot_.LowBattery(), "");
  ReportBattery(87.0F);
  EXPECT_NE(robot_.LowBattery(), "") << "the last level counts";
}

// `present` is false by default: many drivers leave it out.
TEST_F(ARosFlyer, LandsByABatteryThatSaysItIsNotThereWhoseLevelChanges) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  const auto status = msg::BatteryState::kStatusUnknown;
  ReportBattery(0.05F, status, false);
  EXPECT_EQ(robot_.LowBattery(), "") << "it says the same all the time";
  ReportBattery(0.04F, status, false);
  EXPECT_NE(robot_.LowBattery(), "");
  Fly(1);
  EXPECT_LT(peers_->commands.back().linear.z, -0.1);
  ReportBattery(0.0F, status, false);
  EXPECT_NE(robot_.LowBattery(), "");
}

TEST_F(ARosFlyer, BelievesADriverThatItsBatteryIsTakenOut) {
  ReportBattery(0.5F);
  ReportBattery(0.05F, msg::BatteryState::kStatusUnknown, false);
  ReportBattery(0.04F, msg::BatteryState::kStatusUnknown, false);
  EXPECT_EQ(robot_.LowBattery(), "");
}

TEST(BatteryPresence, CountsByLevelsOrAVoltageThatChange) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  BatteryPresence level;
  EXPECT_FALSE(level.Counts(false, 0.5, none));
  EXPECT_FALSE(level.Counts(false, 0.5, none));
  EXPECT_TRUE(level.Counts(false, 0.49, none));
  EXPECT_TRUE(level.Counts(false, 0, none)) << "from then on";
  BatteryPresence voltage;
  EXPECT_FALSE(voltage.Counts(false, 0.5, 11.9));
  EXPECT_TRUE(voltage.Counts(false, 0.5, 11.8));
  BatteryPresence empty;  // an open input, and a level that is never measured
  for (const double volts : {0.1, 0.4, 11.9, 11.7}) EXPECT_FALSE(empty.Counts(false, 0, volts));
}

TEST_F(ARosFlyer, ReadsABatteryThatIsPublishedAsSensorDataAndSaysWhenThereIsNone) {
  Stand(0, 0);
  EXPECT_THAT(robot_.Look().others, IsEmpty());
  peers_->battery =
      peers_->endpoints.Advertise<msg::BatteryState>("r/battery", transport::kSensorDataQos);
  Run(500);
  ReportBattery(0.05F);
  EXPECT_NE(robot_.LowBattery(), "");
  network_.Crash(*world_);
  Run(30'000);
  EXPECT_THAT(robot_.Look().others, Contains("no publisher of r/battery"));
}

// A joystick at rest sends 0 on.
TEST_F(ARosFlyer, KeepsItsPlaceWhileTheStickOfAPersonIsAtRest) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  const double place_m = Fly(2);
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(peers_->teleop->Publish(msg::Twist{}));
    Fly(0.1);
  }
  EXPECT_NEAR(x_m_, place_m, 0.2);
}

// It is in a hand.
TEST_F(ARosFlyer, IsNotUsedByAStickAtRest) {
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(peers_->teleop->Publish(msg::Twist{}));
    Fly(0.1);
  }
  Fly(2);
  EXPECT_THAT(peers_->commands, IsEmpty());
}

TEST_F(ARosFlyer, IsNotHeldUpByAPersonWhileItLandsWithALowBattery) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  Fly(1);
  robot_.StopMotion();
  ReportBattery(0.05F);
  msg::Twist up;
  up.linear = {0.2, 0, 0.5};
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(peers_->teleop->Publish(up));
    Fly(0.1);
  }
  EXPECT_NEAR(peers_->commands.back().linear.x, 0.2, 1e-9) << "to a free place";
  EXPECT_LT(peers_->commands.back().linear.z, -0.1);
}

// Whatever the time of day is where the controller runs.
TEST_F(ARosFlyer, CancelsADriveOfAnotherClientAndLandsWhenItsBatteryIsLow) {
  peers_->clock_ahead = std::chrono::minutes(1);
  const auto client =
      Must(transport::MakeActionClient<msg::FollowPath>(*world_, "dog/r/follow_path"));
  Run(500);
  client->SendGoal({}, Milliseconds(1000), {});
  Fly(1);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  ReportBattery(0.05F);
  Fly(2);
  EXPECT_EQ(peers_->cancels, 1);
  EXPECT_FALSE(robot_.Drives());
  ASSERT_FALSE(peers_->commands.empty());
  EXPECT_LT(peers_->commands.back().linear.z, -0.1);
}

TEST_F(ARosRobot, GetsAPathFromThePlannerOrItsReason) {
  ASSERT_TRUE(robot_.HasPlanner());
  const auto good = robot_.ComputePath({{3, 1, 0}, 0}, std::nullopt);
  Run(100);
  ASSERT_THAT(peers_->plans, SizeIs(1));
  EXPECT_FALSE(peers_->plans[0].goal().use_start);
  EXPECT_EQ(peers_->plans[0].goal().goal.pose.position.x, 3);
  msg::ComputePathToPose::Result result;
  result.path = ToMessage(navigation::Path{{{0, 0, 0}, 0}, {{3, 1, 0}, 0}}, {});
  peers_->plans[0].Succeed(result);
  const auto path = ResultOf(good);
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_EQ(path.value().back().at.x_m, 3);

  const auto bad = robot_.ComputePath({{3, 1, 0}, 0}, navigation::Pose{});
  Run(100);
  EXPECT_TRUE(peers_->plans[1].goal().use_start);
  result.error_code = msg::ComputePathToPose::kGoalOccupied;
  peers_->plans[1].Abort(result);
  EXPECT_EQ(ResultOf(bad).error().message,
            "the goal (3.00, 1.00) has no room for the robot: an obstacle is too near");
}

TEST_F(ARosRobot, CancelsAPlanningThatNoSkillWantsAnyMore) {
  auto path = robot_.ComputePath({{3, 1, 0}, 0}, std::nullopt);
  Run(100);
  ASSERT_THAT(peers_->plans, SizeIs(1));
  path.Drop();
  Run(200);
  EXPECT_EQ(peers_->plans[0].state(), transport::GoalState::kCanceled);
}

TEST_F(ARosRobot, DrivesAlongAPathAndReportsTheDistance) {
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  EXPECT_FALSE(drive->distance_to_goal_m());
  peers_->drives[0].PublishFeedback({1.5F, 0.5F});
  Run(50);
  EXPECT_EQ(drive->distance_to_goal_m(), 1.5);
  peers_->drives[0].Succeed({});
  EXPECT_EQ(ResultOf(drive->end()).value(), true);
}

TEST_F(ARosRobot, SaysWhyADriveFailed) {
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  msg::FollowPath::Result result;
  result.error_code = msg::FollowPath::kPatienceExceeded;
  peers_->drives[0].Abort(result);
  EXPECT_EQ(ResultOf(drive->end()).error().message, "an obstacle stays in the way");
}

TEST_F(ARosRobot, CancelsADriveAlsoBeforeItsServerKnowsIt) {
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  drive->Cancel();
  EXPECT_EQ(ResultOf(drive->end()).value(), false);
  EXPECT_EQ(peers_->cancels, 1);
  auto dropped = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  dropped.reset();
  Run(100);
  EXPECT_EQ(peers_->cancels, 2);
}

TEST_F(ARosRobot, RepeatsACancellationThatIsLost) {
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  network_.Pause(*world_);
  drive->Cancel();
  Run(2500);
  network_.Resume(*world_);
  Run(1500);
  EXPECT_EQ(ResultOf(drive->end()).value(), false);
}

TEST_F(ARosRobot, FailsADriveWhoseControllerHasCrashed) {
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  network_.Crash(*world_);
  const auto end = ResultOf(drive->end());
  ASSERT_FALSE(end);
  EXPECT_THAT(end.error().message, HasSubstr("the controller: "));
  EXPECT_FALSE(robot_.HasController());
}

TEST_F(ARosRobot, CancelsADriveThatItHasLostOnceItsControllerGoesOn) {
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  network_.Partition("robot", "world");
  ASSERT_FALSE(ResultOf(drive->end()));
  network_.Heal("robot", "world");
  Run(3000);
  EXPECT_EQ(peers_->cancels, 1);
  const auto later = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(2000);
  ASSERT_THAT(peers_->drives, SizeIs(2));
  EXPECT_EQ(peers_->drives[1].state(), transport::GoalState::kExecuting);
  EXPECT_EQ(peers_->cancels, 1);
}

TEST_F(ARosRobot, CancelsTheDriveThatACrashedProcessHasLeft) {
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  network_.Crash(*body_);
  Run(100);
  EXPECT_EQ(peers_->cancels, 0);
  const std::unique_ptr<transport::Node> node = network_.MakeNode("robot");
  transport::Endpoints endpoints(*node, "dog");
  RosRobot next(ConfigOfR());
  next.Open(endpoints, "dog");
  Run(500);
  next.CancelEarlierDrives();
  Run(100);
  EXPECT_EQ(peers_->cancels, 1);
}

// Where the time of day is set back in a drive, it is a drive of the future.
TEST_F(ARosRobot, CancelsTheDriveThatACrashedProcessHasLeftAlsoWhereTheControllersClockIsAhead) {
  peers_->clock_ahead = std::chrono::minutes(1);
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  network_.Crash(*body_);
  const std::unique_ptr<transport::Node> node = network_.MakeNode("robot");
  transport::Endpoints endpoints(*node, "dog");
  RosRobot next(ConfigOfR());
  next.Open(endpoints, "dog");
  Run(500);
  next.CancelEarlierDrives();
  Run(100);
  EXPECT_EQ(peers_->cancels, 1);
  EXPECT_FALSE(next.Drives());
}

// Also while no skill is stepped, as in SelfCheck.
TEST_F(ARosRobot, CancelsAnEarlierDriveAgainUntilItHasEnded) {
  const auto client =
      Must(transport::MakeActionClient<msg::FollowPath>(*world_, "dog/r/follow_path"));
  Run(500);
  client->SendGoal({}, Milliseconds(1000), {});
  Run(300);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  peers_->refuses_cancels = 2;
  robot_.CancelEarlierDrives();
  network_.RunFor(Milliseconds(100));
  EXPECT_TRUE(robot_.Drives()) << "the reply says that it is not cancelled";
  network_.RunFor(Milliseconds(3000));
  EXPECT_EQ(peers_->cancels, 1);
  EXPECT_EQ(peers_->drives[0].state(), transport::GoalState::kCanceled);
  EXPECT_FALSE(robot_.Drives());
}

TEST_F(ARosRobot, CancelsTheDriveOfAControllerThatIsOutOfReachOnceItIsBackAndNoLaterOne) {
  const std::unique_ptr<transport::Node> desk = network_.MakeNode("desk");
  const auto client =
      Must(transport::MakeActionClient<msg::FollowPath>(*desk, "dog/r/follow_path"));
  Run(500);
  client->SendGoal({}, Milliseconds(1000), {});
  Run(300);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  network_.Partition("robot", "world");
  Run(30'000);
  ASSERT_FALSE(robot_.HasController());
  robot_.CancelEarlierDrives();
  Run(30'000);
  network_.Heal("robot", "world");
  Run(5000);
  EXPECT_EQ(peers_->drives[0].state(), transport::GoalState::kCanceled);
  client->SendGoal({}, Milliseconds(1000), {});
  Run(5000);
  ASSERT_THAT(peers_->drives, SizeIs(2));
  EXPECT_EQ(peers_->drives[1].state(), transport::GoalState::kExecuting);
  EXPECT_EQ(peers_->cancels, 1);
}

// The controller has published no status before.
TEST_F(ARosRobot, CancelsNoDriveThatAnotherClientBeginsLater) {
  const auto client =
      Must(transport::MakeActionClient<msg::FollowPath>(*world_, "dog/r/follow_path"));
  Run(5000);
  robot_.CancelEarlierDrives();
  client->SendGoal({}, Milliseconds(1000), {});
  Run(5000);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  EXPECT_EQ(peers_->drives[0].state(), transport::GoalState::kExecuting);
}

TEST_F(ARosRobot, CancelsAnEarlierDriveOnceItReachesTheControllerAndNoLaterOne) {
  const auto earlier = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  network_.Crash(*body_);
  const std::unique_ptr<transport::Node> node = network_.MakeNode("robot");
  transport::Endpoints endpoints(*node, "dog");
  RosRobot next(ConfigOfR());
  next.CancelEarlierDrives();  // before its topics are open
  next.Open(endpoints, "dog");
  const auto run = [&](int ms) {
    for (; ms > 0; ms -= 10) {
      Run(10);
      next.BeginStep(node->loop().Now());
    }
  };
  EXPECT_FALSE(next.HasController());
  run(1000);
  EXPECT_EQ(peers_->cancels, 1);
  const auto later = next.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  run(3000);
  ASSERT_THAT(peers_->drives, SizeIs(2));
  EXPECT_EQ(peers_->drives[1].state(), transport::GoalState::kExecuting);
  EXPECT_EQ(peers_->cancels, 1);
}

TEST_F(ARosRobot, IsNotDrivenByAControllerThatHasCrashedInADriveAndStartsAgain) {
  const std::unique_ptr<transport::Node> desk = network_.MakeNode("desk");
  const auto client =
      Must(transport::MakeActionClient<msg::FollowPath>(*desk, "dog/r/follow_path"));
  Run(500);
  client->SendGoal({}, Milliseconds(1000), {});
  Run(300);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  EXPECT_TRUE(robot_.Drives());
  network_.Crash(*world_);
  const std::unique_ptr<transport::Node> node = network_.MakeNode("world");
  const Peers restarted(*node);
  for (int i = 0; i < 60 && robot_.Drives(); ++i) Run(500);
  EXPECT_TRUE(robot_.HasController());
  EXPECT_FALSE(robot_.Drives());
}

TEST_F(ARosRobot, StandsAndCancelsItsDrivesAtRest) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  const auto path = robot_.ComputePath({{3, 1, 0}, 0}, std::nullopt);
  Run(100);
  robot_.StandStill();
  Run(100);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  EXPECT_EQ(ResultOf(drive->end()).value(), false);
  EXPECT_EQ(ResultOf(path).error().message, "the planning was cancelled");
}

TEST_F(ARosRobot, StandsWhenItsTopicsAreClosed) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  endpoints_.reset();
  Run(100);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  EXPECT_EQ(peers_->cancels, 1);
  robot_.SetVelocity({0.5, 0, 0, 0});  // goes nowhere
  drive->Cancel();
  EXPECT_TRUE(drive->end().done()) << "what waits for its end goes on";
  EXPECT_FALSE(robot_.HasPlanner());
  EXPECT_THAT(ResultOf(robot_.TakePicture("front")).error().message, HasSubstr("not open"));
}

TEST_F(ARosRobot, SeesObstaclesObjectsTheLineAndWhatItTracks) {
  EXPECT_FALSE(robot_.HasScan());
  EXPECT_FALSE(robot_.PoseOf("/target_0/odom"));  // subscribes
  EXPECT_FALSE(robot_.PoseOf("not a topic"));
  Run(500);
  Stand(1, 0);
  msg::LaserScan scan;
  scan.range_max = 10;
  scan.ranges = {2};
  EXPECT_TRUE(peers_->scan->Publish(scan));
  msg::ObjectStates objects;
  objects.objects.resize(1);
  objects.objects[0].name = "box";
  EXPECT_TRUE(peers_->objects->Publish(objects));
  msg::YellowLines lines;
  lines.contours = 1;
  lines.middle_offset = 0.25F;
  EXPECT_TRUE(peers_->line->Publish(lines));
  msg::Odometry target;
  target.pose.pose.position.x = 7;
  EXPECT_TRUE(peers_->target->Publish(target));
  Run(50);
  ASSERT_THAT(robot_.obstacles(), SizeIs(1));
  EXPECT_NEAR(robot_.obstacles()[0].x_m, 3, 1e-9);
  EXPECT_TRUE(robot_.HasObjects());
  EXPECT_THAT(robot_.objects(), SizeIs(1));
  ASSERT_TRUE(robot_.line());
  EXPECT_NEAR(robot_.line()->offset_m, -0.2, 1e-6);
  ASSERT_TRUE(robot_.PoseOf("/target_0/odom"));
  EXPECT_EQ(robot_.PoseOf("/target_0/odom")->at.x_m, 7);
  EXPECT_EQ(robot_.PosesOf("/target_0/odom"), 1U);
  target.header.stamp = {7, 0};
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(peers_->target->Publish(target));
  Run(50);
  EXPECT_EQ(robot_.PosesOf("/target_0/odom"), 2U) << "what is published again is not seen";
  lines.contours = 0;
  EXPECT_TRUE(peers_->line->Publish(lines));
  Run(50);
  EXPECT_FALSE(robot_.line());
  Run(600);
  EXPECT_FALSE(robot_.HasScan());
  EXPECT_THAT(robot_.objects(), IsEmpty());
  EXPECT_FALSE(robot_.PoseOf("/target_0/odom"));
}

TEST_F(ARosRobot, SeesNoLineInAPictureThatIsRepeated) {
  msg::YellowLines lines;
  lines.contours = 1;
  lines.middle_offset = 0.25F;
  for (int i = 0; i < 10; ++i) {
    lines.header.stamp = {7 + i, 0};
    EXPECT_TRUE(peers_->line->Publish(lines));
    Run(100);
    EXPECT_TRUE(robot_.line());
  }
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(peers_->line->Publish(lines));
    Run(100);
  }
  EXPECT_FALSE(robot_.line());
}

TEST_F(ARosRobot, TracksATopicAlsoAfterManyOthers) {
  for (int i = 1; i <= 20; ++i) {
    EXPECT_FALSE(robot_.PoseOf("/target_" + std::to_string(i) + "/odom"));
    Run(1);
  }
  EXPECT_FALSE(robot_.PoseOf("/target_0/odom"));  // subscribes
  Run(500);
  EXPECT_TRUE(peers_->target->Publish({}));
  Run(50);
  EXPECT_TRUE(robot_.PoseOf("/target_0/odom"));
}

TEST_F(ARosRobot, SubscribesToACameraWhileAPictureIsWanted) {
  EXPECT_EQ(peers_->camera->MatchedReaders(), 0);
  const auto picture = robot_.TakePicture("front");
  Run(500);
  EXPECT_EQ(peers_->camera->MatchedReaders(), 1);
  msg::Image image;
  image.width = image.height = 1;
  image.step = 3;
  image.encoding = "bgr8";
  image.data = {1, 2, 3};
  EXPECT_TRUE(peers_->camera->Publish(image));
  EXPECT_THAT(ResultOf(picture).value().bgr, ElementsAre(1, 2, 3));
  Run(500);
  EXPECT_EQ(peers_->camera->MatchedReaders(), 0);
  auto dropped = robot_.TakePicture("front");
  Run(500);
  dropped.Drop();
  Run(500);
  EXPECT_EQ(peers_->camera->MatchedReaders(), 0);
  EXPECT_THAT(ResultOf(robot_.TakePicture("frnt")).error().message,
              HasSubstr("did you mean 'front'?"));
}

TEST_F(ARosRobot, UsesItsHand) {
  HandRequest request;
  request.action = HandAction::kAttach;
  request.object = "box_red";
  const auto reply = ResultOf(robot_.UseHand(request));
  ASSERT_TRUE(reply) << reply.error().message;
  EXPECT_EQ(reply.value().message, "Object attached");
  EXPECT_EQ(reply.value().distance_m, 0.4);
  EXPECT_EQ(peers_->hand_object, "box_red");
  network_.Crash(*world_);
  EXPECT_THAT(ResultOf(robot_.UseHand(request)).error().message, HasSubstr("the hand: "));
}

TEST_F(ARosRobot, NamesWhatItCannotReach) {
  EXPECT_EQ(robot_.Look().odometry, "no odometry on r/odom");
  EXPECT_THAT(robot_.Look().others, IsEmpty());
  Stand(0, 0);
  EXPECT_EQ(robot_.Look().odometry, "");
  network_.Crash(*world_);
  Run(30'000);
  EXPECT_THAT(robot_.Look().others, Contains("no server of r/compute_path_to_pose"));
  EXPECT_THAT(robot_.Look().others, Contains("no publisher of r/scan"));
}

}  // namespace musher::skills::ros_robot_test
