// Robots on a network: their topics and services, in virtual time.

#include "musher/modules/world/process/world_robots.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "musher/messages/nav_msgs/occupancy_grid.hpp"
#include "musher/messages/nav_msgs/path.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/sensor_msgs/point_cloud2.hpp"
#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/modules/world/rooms.hpp"
#include "musher/test/modules/world/world_on_network.hpp"

namespace musher::world::robots_host_test {

using std::chrono::seconds;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Control = msg::ManipulationControl;

class RobotsHostTest : public WorldOnNetwork {
 protected:
  void Open(const Scene& scene) {
    StartWorld(scene, &shooter_);
    network_.RunFor(Milliseconds(200));
  }
  template <class Twist>
  void Drive(const std::string& robot, const Twist& twist, Duration time) {
    Send(robot + "/cmd_vel", twist, time);
  }
  Control::Response UseHand(const std::string& robot, const Control::Request& request) {
    auto client = transport::MakeClient<Control>(*desk_, robot + "/manipulation_control").value();
    network_.RunFor(Milliseconds(100));
    Control::Response response;
    client->Call(request, seconds(1), [&](const Result<Control::Response>& answer) {
      response.message = answer ? answer.value().message : answer.error().message;
      if (answer) response = answer.value();
    });
    network_.RunFor(seconds(1));
    return response;
  }
};

TEST_F(RobotsHostTest, PublishesWhatTheDetectorOfARobotFinds) {
  Scene scene = RobotYard();
  scene.objects = {BoxOf("box_red", {3, 0, 0.075}), BoxOf("box_blue", {-2, 0, 0.075})};
  scene.robots[0].detector = DetectorSpec{.noise_m = 0};
  Open(scene);
  std::vector<msg::ObjectStates> found;
  Keep("jetbot_0/detections", found, transport::kSensorDataQos);
  found.clear();
  network_.RunFor(seconds(2));
  EXPECT_THAT(found, SizeIs(20));
  ASSERT_THAT(found.back().objects, SizeIs(1));
  EXPECT_EQ(found.back().header.frame_id, "jetbot_0");
  EXPECT_EQ(found.back().objects[0].name, "box_red");
  EXPECT_EQ(found.back().objects[0].pose.position.x, 3);
}

TEST_F(RobotsHostTest, PublishesWhatTheSensorBelowAFlyerMeasures) {
  Scene scene = RobotYard();
  scene.robots[2].start_m.z() = 1.5;
  scene.robots[2].range_down.emplace();
  Open(scene);
  std::vector<msg::Range> ranges;
  Keep("cf2x_0/range_down", ranges, transport::kSensorDataQos);
  ranges.clear();
  network_.RunFor(seconds(2));
  EXPECT_NEAR(static_cast<double>(ranges.size()), 40, 2);
  ASSERT_FALSE(ranges.empty());
  EXPECT_NEAR(ranges.back().range, 1.5, 0.1);
}

TEST_F(RobotsHostTest, DrivesARobotAndPublishesItsOdometry50TimesASecond) {
  Open(RobotYard());
  std::vector<msg::Odometry> odometry;
  Keep("jetbot_0/odom", odometry);
  msg::Twist ahead;
  ahead.linear.x = 1;
  Drive("jetbot_0", ahead, seconds(2));
  const msg::Odometry& last = odometry.back();
  EXPECT_EQ(last.header.frame_id, "map");
  EXPECT_EQ(last.child_frame_id, "jetbot_0");
  EXPECT_NEAR(last.twist.twist.linear.x, 1, 1e-6);
  EXPECT_GT(last.pose.pose.position.x, 1.7);
  network_.RunFor(seconds(1));
  EXPECT_EQ(odometry.back().twist.twist.linear.x, 0) << "no command came for half a second";
  odometry.clear();
  network_.RunFor(seconds(2));
  EXPECT_THAT(odometry, SizeIs(100));
}

TEST_F(RobotsHostTest, DrivesARobotByStampedVelocitiesIfItsSceneSaysSo) {
  Scene scene = RobotYard();
  scene.robots[0].stamped_command = true;
  Open(scene);
  msg::TwistStamped ahead;
  ahead.twist.linear.x = 1;
  Drive("jetbot_0", ahead, seconds(2));
  EXPECT_GT(host_->world().fleet().robots()[0].body.position_m().x(), 1.7);
}

TEST_F(RobotsHostTest, MovesNothingForAVelocityThatIsNoNumberAndLogsItOnce) {
  Open(RobotYard());
  msg::Twist bad;
  bad.linear.x = std::numeric_limits<double>::quiet_NaN();
  Drive("jetbot_0", bad, seconds(1));
  EXPECT_EQ(host_->world().fleet().robots()[0].body.position_m().x(), 0);
  EXPECT_THAT(log_, SizeIs(1));
  EXPECT_THAT(log_, Contains("jetbot_0: a velocity that is not a number is refused"));
}

TEST_F(RobotsHostTest, LatchesTheMapsForWhateverSubscribesLater) {
  Open(RobotYard());
  std::vector<msg::OccupancyGrid> maps;
  std::vector<msg::PointCloud2> clouds;
  Keep("map", maps, transport::kLatchedQos);
  Keep("map_point_cloud", clouds, transport::kLatchedQos);
  ASSERT_THAT(maps, SizeIs(1));
  EXPECT_EQ(maps[0].header.frame_id, "map");
  EXPECT_NEAR(maps[0].info.resolution, 0.05, 1e-6);
  ASSERT_THAT(clouds, SizeIs(1));
  EXPECT_EQ(clouds[0].fields.size(), 3u);
}

TEST_F(RobotsHostTest, PublishesTheMapsAgainWithTheObjectsThatStandThere) {
  Scene scene = RobotYard();
  scene.objects = {BoxOf("box_red", {0.8, 0, 0.075})};
  Open(scene);
  std::vector<msg::OccupancyGrid> maps;
  Keep("map", maps, transport::kLatchedQos);
  auto client = transport::MakeClient<msg::SetBool>(*desk_, "world/map").value();
  network_.RunFor(Milliseconds(200));
  for (const bool objects : {true, false}) {
    client->Call({objects}, seconds(1), [](const auto& answer) { EXPECT_TRUE(answer); });
    network_.RunFor(seconds(1));
  }
  ASSERT_THAT(maps, SizeIs(3));
  const auto occupied = [](const msg::OccupancyGrid& map) {
    return std::ranges::count_if(map.data, [](auto cell) { return cell > 50; });
  };
  EXPECT_GT(occupied(maps[1]), occupied(maps[0]));
  EXPECT_EQ(maps[2].data, maps[0].data);
}

TEST_F(RobotsHostTest, PublishesAWrongOdometryUntilItIsRightAgain) {
  Open(RobotYard());
  std::vector<msg::Odometry> odometry;
  Keep("jetbot_0/odom", odometry);
  auto faults = transport::MakePublisher<msg::String>(*desk_, "world/jetbot_0/odometry").value();
  network_.RunFor(Milliseconds(200));
  const auto set = [&](const std::string& text) {
    EXPECT_TRUE(faults->Publish({text}));
    network_.RunFor(Milliseconds(200));
  };
  const auto x_m = [&] { return odometry.back().pose.pose.position.x; };
  const double right_m = x_m();
  set("jump 30 -2");
  EXPECT_NEAR(x_m(), right_m + 30, 1e-6);
  EXPECT_NEAR(odometry.back().pose.pose.position.y, -2, 1e-6);
  set("freeze");
  EXPECT_NEAR(x_m(), right_m, 1e-6);
  msg::Twist ahead;
  ahead.linear.x = 1;
  Drive("jetbot_0", ahead, seconds(1));
  EXPECT_NEAR(x_m(), right_m, 1e-6);
  EXPECT_GT(odometry.back().header.stamp.sec, 0);
  set("melt");
  EXPECT_NEAR(x_m(), right_m, 1e-6);
  EXPECT_THAT(log_, Contains("jetbot_0: odometry: expected freeze, jump X Y or right, found "
                             "\"melt\""));
  set("right");
  EXPECT_GT(x_m(), right_m + 0.5);
}

TEST_F(RobotsHostTest, PublishesTheLinesInTheViewOfARobot) {
  Scene scene = RobotYard();
  scene.robots[0].line_view = LineViewSpec{0.2, 0.8, 0.6};
  scene.lines.push_back({.points_m = {{-1, 0.2}, {0.5, 0.2}}});
  Open(scene);
  std::vector<msg::YellowLines> lines;
  Keep("jetbot_0/lines", lines);
  network_.RunFor(seconds(1));
  ASSERT_FALSE(lines.empty());
  const msg::YellowLines& last = lines.back();
  EXPECT_EQ(last.contours, 1U);
  EXPECT_NEAR(last.middle_offset, -0.25, 0.01) << "20 cm to the left of 80 cm";
  ASSERT_FALSE(last.edge_x.empty());
  EXPECT_NEAR(last.edge_x[0], 0.25, 0.01);
  const auto [high, low] = std::ranges::minmax(last.edge_y);
  EXPECT_NEAR(low, 1, 0.05);
  EXPECT_NEAR(high, 0.5, 0.05) << "it ends in the middle of the view";
  msg::Twist turn;
  turn.angular.z = -1.5;
  Drive("jetbot_0", turn, seconds(1));
  EXPECT_EQ(lines.back().contours, 0U);
}

TEST_F(RobotsHostTest, PublishesScansBatteriesObjectsAndTrackedMoversAtTheirRates) {
  Scene scene = RobotYard();
  scene.objects = {BoxOf("box_red", {0.8, 0, 0.075})};
  scene.movers = {MoverSpec{.name = "target_0", .points_m = {{2, 2}, {4, 2}}, .tracked = true},
                  MoverSpec{.name = "person_0", .points_m = {{2, 4}, {4, 4}}}};
  Open(scene);
  std::vector<msg::LaserScan> scans;
  std::vector<msg::BatteryState> batteries;
  std::vector<msg::ObjectStates> objects;
  std::vector<msg::Odometry> target, person;
  Keep("cf2x_0/scan", scans, transport::kSensorDataQos);
  Keep("jetbot_1/battery", batteries);
  Keep("world/objects", objects);
  Keep("target_0/odom", target);
  Keep("person_0/odom", person);
  scans.clear();
  batteries.clear();
  objects.clear();
  target.clear();
  network_.RunFor(seconds(10));
  EXPECT_NEAR(static_cast<double>(scans.size()), 100, 1);
  EXPECT_NEAR(static_cast<double>(batteries.size()), 10, 1);
  EXPECT_NEAR(static_cast<double>(objects.size()), 100, 1);
  EXPECT_NEAR(static_cast<double>(target.size()), 500, 1);
  EXPECT_THAT(person, IsEmpty());
  ASSERT_THAT(objects.back().objects, SizeIs(1));
  EXPECT_EQ(objects.back().objects[0].name, "box_red");
  EXPECT_EQ(objects.back().objects[0].held_by, "");
  EXPECT_GT(target.back().pose.pose.position.x, 2);
}

TEST_F(RobotsHostTest, ServesTheHandOfARobotThatHasOne) {
  Scene scene = RobotYard();
  scene.objects = {BoxOf("box_red", {0.8, 0, 0.075})};
  Open(scene);
  const Control::Response taken = UseHand(
      "jetbot_0",
      {.action = Control::kAttach, .object = "box_red", .distance_threshold_m = 2, .target = {}});
  EXPECT_TRUE(taken.success);
  EXPECT_EQ(taken.message, "Object attached");
  EXPECT_GT(taken.distance_m, 0);
  const Control::Response unknown = UseHand(
      "jetbot_0", {.action = 9, .object = "box_red", .distance_threshold_m = 2, .target = {}});
  EXPECT_FALSE(unknown.success);
  EXPECT_THAT(unknown.message, HasSubstr("unknown action 9"));
  std::vector<msg::ObjectStates> objects;
  Keep("world/objects", objects);
  EXPECT_EQ(objects.back().objects[0].held_by, "jetbot_0");
  const Control::Response released =
      UseHand("jetbot_0",
              {.action = Control::kRelease, .object = "", .distance_threshold_m = 0, .target = {}});
  EXPECT_EQ(released.message, "Object released");
}

TEST_F(RobotsHostTest, RendersACameraOnlyForASubscriberWithTheOtherRobotInIt) {
  Scene scene = RobotYard();
  scene.robots[1].start_m = {1.2, 0, 0};
  scene.robots[1].color = {250, 0, 0};
  CameraSpec camera;
  camera.position_m = {0.2, 0, 0.15};
  camera.width_px = 64;
  camera.height_px = 48;
  camera.rate_hz = 5;
  camera.noise = 0;
  scene.robots[0].camera = camera;
  Open(scene);
  std::vector<msg::Image> images;
  Keep("jetbot_0/camera/image", images, transport::kSensorDataQos);
  images.clear();
  network_.RunFor(seconds(2));
  ASSERT_THAT(images, SizeIs(10));
  const msg::Image& image = images.back();
  EXPECT_EQ(image.encoding, "bgr8");
  const std::size_t middle = (24 * 64 + 32) * 3;
  EXPECT_GT(int{image.data[middle + 2]}, 100);
  EXPECT_LT(int{image.data[middle]}, 40);
}

TEST_F(RobotsHostTest, PublishesNothingOfTheBodyWithoutOne) {
  Open(RobotYard());
  std::vector<msg::BodyState> bodies;
  Keep("world/body_state", bodies);
  network_.RunFor(seconds(1));
  EXPECT_THAT(bodies, IsEmpty());
}

TEST_F(RobotsHostTest, TakesAPlannedPathForThePictureAndReportsItsRobots) {
  Open(RobotYard());
  auto paths =
      transport::MakePublisher<msg::Path>(*desk_, "jetbot_0/planned_path", transport::kLatchedQos)
          .value();
  network_.RunFor(Milliseconds(100));
  msg::Path path;
  path.poses.resize(4);
  path.poses[3].pose.position.x = 1e15;  // the picture would have a dash for each of its pixels
  path.poses[2].pose.position.x = 2;
  path.poses[1].pose.position.x = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(paths->Publish(path));
  network_.RunFor(Milliseconds(100));
  EXPECT_THAT(host_->world().fleet().robots()[0].planned_m, SizeIs(2));
  auto client = transport::MakeClient<msg::Trigger>(*desk_, "world/robots_json").value();
  network_.RunFor(Milliseconds(100));
  std::string report;
  client->Call({}, seconds(1), [&](const Result<msg::Trigger::Response>& answer) {
    if (answer) report = answer.value().message;
  });
  network_.RunFor(seconds(1));
  EXPECT_THAT(report, HasSubstr(R"("name":"cf2x_0","kind":"flyer")"));
}

}  // namespace musher::world::robots_host_test
