// A robot behind its topics, on a simulated network in virtual time, with fakes of its body, its
// planner, its controller and its hand.

#include "musher/modules/skills/robot/ros_robot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/messages/nav2_msgs/compute_path_to_pose.hpp"
#include "musher/messages/nav2_msgs/follow_path.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::skills::ros_robot_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

template <class T>
T Must(Result<T> result) {
  if (!result) ADD_FAILURE() << result.error().message;
  return std::move(result).value();
}

SkillsConfig Config() {
  auto reading = ReadSkillsText(
      "robot = \"r\"\nkind = \"jetbot\"\nhand = true\n[topics]\nline = \"line\"\n[cameras]\n"
      "front = \"r/camera/image\"\n",
      "/tmp/r.toml");
  return *reading.config;
}

// The body of the robot and the servers for it, in a process of its own.
class Peers {
 public:
  using PlanGoal = transport::ServerGoal<msg::ComputePathToPose>;
  using DriveGoal = transport::ServerGoal<msg::FollowPath>;

  explicit Peers(transport::Node& node) : node(node), endpoints(node, "dog") {
    odometry = endpoints.Advertise<msg::Odometry>("r/odom");
    scan = endpoints.Advertise<msg::LaserScan>("r/scan", transport::kSensorDataQos);
    objects = endpoints.Advertise<msg::ObjectStates>("world/objects");
    line = endpoints.Advertise<msg::YellowLines>("line", transport::kSensorDataQos);
    camera = endpoints.Advertise<msg::Image>("r/camera/image", transport::kSensorDataQos);
    target = endpoints.Advertise<msg::Odometry>("/target_0/odom");
    endpoints.Subscribe<msg::Twist>("r/cmd_vel",
                                    [this](const msg::Twist& twist) { commands.push_back(twist); });
    transport::ActionHandlers<msg::ComputePathToPose> plan;
    plan.start = [this](PlanGoal goal) {
      goal.Execute();
      plans.push_back(goal);
    };
    plan.cancel = [](PlanGoal goal) { goal.Canceled({}); };
    endpoints.ServeAction<msg::ComputePathToPose>("r/compute_path_to_pose", std::move(plan));
    transport::ActionHandlers<msg::FollowPath> drive;
    drive.start = [this](DriveGoal goal) {
      goal.Execute();
      drives.push_back(goal);
    };
    drive.cancel = [this](DriveGoal goal) {
      ++cancels;
      goal.Canceled({});
    };
    endpoints.ServeAction<msg::FollowPath>("r/follow_path", std::move(drive));
    endpoints.Serve<msg::ManipulationControl>("r/manipulation_control",
                                              [this](const auto& request, auto reply) {
                                                hand_object = request.object;
                                                msg::ManipulationControl::Response response;
                                                response.success = true;
                                                response.message = "Object attached";
                                                response.distance_m = 0.4;
                                                reply(response);
                                              });
  }

  transport::Node& node;
  std::vector<msg::Twist> commands;
  std::vector<PlanGoal> plans;
  std::vector<DriveGoal> drives;
  int cancels = 0;
  std::string hand_object;
  transport::Publisher<msg::Odometry>* odometry = nullptr;
  transport::Publisher<msg::LaserScan>* scan = nullptr;
  transport::Publisher<msg::ObjectStates>* objects = nullptr;
  transport::Publisher<msg::YellowLines>* line = nullptr;
  transport::Publisher<msg::Image>* camera = nullptr;
  transport::Publisher<msg::Odometry>* target = nullptr;
  transport::Endpoints endpoints;
};

class ARosRobot : public ::testing::Test {
 protected:
  ARosRobot() : ARosRobot(Config()) {}
  explicit ARosRobot(SkillsConfig config) : robot_(std::move(config)) {
    robot_.Open(*endpoints_, "dog");
    EXPECT_TRUE(endpoints_->opened());
    Run(500);
  }
  void Run(std::int64_t ms) {
    for (; ms > 0; ms -= 10) {
      network_.RunFor(Milliseconds(10));
      robot_.BeginStep(Now());
    }
  }
  Time Now() { return body_->loop().Now(); }
  void Stand(double x_m, double yaw_rad) {
    msg::Odometry odometry;
    odometry.pose.pose = ToMessage(navigation::Pose{{x_m, 0, 0}, yaw_rad}, {}).pose;
    odometry.twist.twist.linear.x = 0.5;
    EXPECT_TRUE(peers_->odometry->Publish(odometry));
    Run(20);
  }
  // Until it is done; virtual time.
  template <class T>
  Result<T> ResultOf(const skill::Future<T>& future) {
    for (int i = 0; i < 3000 && !future.done(); ++i) Run(10);
    if (!future.done()) return Error{kCodeTimeout, "never done"};
    return future.result();
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> body_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> world_ = network_.MakeNode("world");
  std::unique_ptr<Peers> peers_ = std::make_unique<Peers>(*world_);
  RosRobot robot_;
  std::unique_ptr<transport::Endpoints> endpoints_ =
      std::make_unique<transport::Endpoints>(*body_, "dog");
};

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

TEST_F(ARosRobot, PublishesItsVelocityTwentyTimesASecondUntilItStops) {
  robot_.SetVelocity({0.5, 0, 0, 0.25});
  Run(1000);
  EXPECT_NEAR(double(peers_->commands.size()), 21, 2);
  EXPECT_EQ(peers_->commands.back().linear.x, 0.5);
  EXPECT_EQ(peers_->commands.back().angular.z, 0.25);
  robot_.StopMotion();
  Run(50);
  EXPECT_EQ(peers_->commands.back(), msg::Twist{});
  const std::size_t count = peers_->commands.size();
  Run(1000);
  EXPECT_EQ(peers_->commands.size(), count);
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

TEST_F(ARosRobot, CancelsTheDriveThatACrashedProcessHasLeft) {
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  Run(100);
  ASSERT_THAT(peers_->drives, SizeIs(1));
  network_.Crash(*body_);
  Run(100);
  EXPECT_EQ(peers_->cancels, 0);
  const std::unique_ptr<transport::Node> node = network_.MakeNode("robot");
  transport::Endpoints endpoints(*node, "dog");
  RosRobot next(Config());
  next.Open(endpoints, "dog");
  Run(500);
  next.CancelEarlierDrives();
  Run(100);
  EXPECT_EQ(peers_->cancels, 1);
}

TEST_F(ARosRobot, StandsAndCancelsItsDrivesAtRest) {
  robot_.SetVelocity({0.5, 0, 0, 0});
  const auto drive = robot_.FollowPath({{{0, 0, 0}, 0}, {{3, 1, 0}, 0}});
  const auto path = robot_.ComputePath({{3, 1, 0}, 0}, std::nullopt);
  Run(100);
  robot_.Rest();
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
  lines.contours = 0;
  EXPECT_TRUE(peers_->line->Publish(lines));
  Run(50);
  EXPECT_FALSE(robot_.line());
  Run(600);
  EXPECT_FALSE(robot_.HasScan());
  EXPECT_THAT(robot_.objects(), IsEmpty());
  EXPECT_FALSE(robot_.PoseOf("/target_0/odom"));
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

class ARosRobotWithDetectors : public ARosRobot {
 protected:
  ARosRobotWithDetectors() : ARosRobot(WithDetectors()) {
    qr_ = Must(transport::MakePublisher<msg::Sighting>(peers_->node, "dog/qr/sighting"));
    arrow_ = Must(transport::MakePublisher<msg::Sighting>(peers_->node, "dog/arrow/sighting"));
    Run(500);
  }
  static SkillsConfig WithDetectors() {
    SkillsConfig config = Config();
    config.detectors = {{"qr", "qr/sighting", 0.4, M_PI / 2, {}},
                        {"arrow", "arrow/sighting", 0.4, M_PI / 2, {}}};
    return config;
  }

  std::unique_ptr<transport::Publisher<msg::Sighting>> qr_;
  std::unique_ptr<transport::Publisher<msg::Sighting>> arrow_;
};

TEST_F(ARosRobotWithDetectors, DetectsWhatTheyHaveSeenOnceAllHaveLooked) {
  msg::Sighting sighting;
  sighting.seen = true;
  sighting.text = "A-1";
  sighting.x = 0.4F;
  sighting.width = 0.2F;
  sighting.distance_m = 2;
  EXPECT_FALSE(robot_.Detect());
  Run(500);
  Stand(1, 0);
  EXPECT_TRUE(qr_->Publish(sighting));
  Run(20);
  EXPECT_FALSE(robot_.Detect());
  EXPECT_TRUE(arrow_->Publish({}));
  Run(20);
  const auto seen = robot_.Detect();
  ASSERT_TRUE(seen);
  ASSERT_THAT(*seen, SizeIs(1));
  EXPECT_EQ(seen->front().name, "A-1");
  EXPECT_NEAR(seen->front().pose.at.x_m, 3, 1e-6);
  Run(1100);
  EXPECT_FALSE(robot_.Detect());
}

TEST_F(ARosRobotWithDetectors, AsksThemToLookOnlyWhileASkillDetects) {
  EXPECT_EQ(qr_->MatchedReaders(), 0U);
  EXPECT_FALSE(robot_.Detect());
  Run(500);
  EXPECT_EQ(qr_->MatchedReaders(), 1U);
  EXPECT_EQ(arrow_->MatchedReaders(), 1U);
  Run(6000);
  EXPECT_EQ(qr_->MatchedReaders(), 0U);
}

}  // namespace musher::skills::ros_robot_test
