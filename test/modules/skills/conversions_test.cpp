// Messages of a robot as the values that skills use.

#include "musher/modules/skills/robot/conversions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "musher/messages/nav2_msgs/compute_path_to_pose.hpp"
#include "musher/messages/nav2_msgs/follow_path.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::skills::conversions_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Result<navigation::Pose> InMap(const std::string& frame) {
  if (frame == "odom") return navigation::Pose{{10, 0, 0}, M_PI / 2};
  if (frame.empty() || frame == kMapFrame) return navigation::Pose{};
  return Error{kCodeFailed, "no transform from map to " + frame};
}

TEST(Conversions, ReadWhatTheyWrite) {
  const navigation::Pose pose{{1, -2, 3}, 2.5};
  const auto back = ToPose(ToMessage(pose, {7, 8}).pose);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->at, pose.at);
  EXPECT_NEAR(back->yaw_rad, 2.5, 1e-9);
  EXPECT_EQ(ToMessage(pose, {7, 8}).header.frame_id, "map");
  const auto path = ToPath(ToMessage(navigation::Path{pose, pose}, {}), InMap);
  ASSERT_TRUE(path);
  EXPECT_EQ(path.value().size(), 2U);
}

TEST(Conversions, PlaceAPathByItsFrame) {
  msg::Path message = ToMessage(navigation::Path{{{2, 1, 0}, 0}}, {});
  message.header.frame_id = "odom";
  const auto path = ToPath(message, InMap);
  ASSERT_TRUE(path);
  EXPECT_NEAR(path.value()[0].at.x_m, 9, 1e-9);
  EXPECT_NEAR(path.value()[0].at.y_m, 2, 1e-9);
  EXPECT_NEAR(path.value()[0].yaw_rad, M_PI / 2, 1e-9);
  message.header.frame_id = "moon";
  EXPECT_EQ(ToPath(message, InMap).error().message, "no transform from map to moon");
}

TEST(Conversions, RefuseAPoseThatIsNotFiniteOrHasNoDirection) {
  msg::Pose pose;
  pose.position.x = kNan;
  EXPECT_FALSE(ToPose(pose));
  pose = {};
  pose.orientation = {0, 0, 0, 0};
  EXPECT_FALSE(ToPose(pose));
  pose.orientation = {0, 0, 0, 2};  // of another length
  EXPECT_TRUE(ToPose(pose));
  EXPECT_FALSE(ToPath({}, InMap));
}

TEST(Conversions, TurnTheVelocityOfTheBodyIntoTheMap) {
  msg::Twist twist;
  twist.linear = {1, 0, 0.5};
  twist.angular.z = 0.25;
  const navigation::Velocity velocity = ToMapFrame(twist, M_PI / 2);
  EXPECT_NEAR(velocity.x_m_s, 0, 1e-9);
  EXPECT_NEAR(velocity.y_m_s, 1, 1e-9);
  EXPECT_EQ(velocity.z_m_s, 0.5);
  EXPECT_EQ(velocity.yaw_rad_s, 0.25);
}

TEST(Conversions, NeverCommandANumberThatIsNotFinite) {
  const msg::Twist twist = ToMessage({kNan, INFINITY, 0.5, -INFINITY});
  EXPECT_EQ(twist.linear, (msg::Vector3{0, 0, 0.5}));
  EXPECT_EQ(twist.angular.z, 0);
}

TEST(Conversions, GiveAScanItsLimits) {
  msg::LaserScan scan;
  scan.angle_min = 0;
  scan.angle_increment = static_cast<float>(M_PI / 2);
  scan.range_min = 0.1F;
  scan.range_max = 10;
  scan.ranges = {2, INFINITY, 0.05F, 20};
  const navigation::Scan converted = ToScan(scan);
  EXPECT_EQ(converted.from_rad, 0);
  EXPECT_NEAR(converted.step_rad, M_PI / 2, 1e-6);
  EXPECT_NEAR(converted.least_m, 0.1, 1e-6);
  EXPECT_EQ(converted.most_m, 10);
  EXPECT_EQ(converted.ranges_m, scan.ranges);
}

TEST(Conversions, ReadPicturesOfAllEncodings) {
  msg::Image image;
  image.width = 1;
  image.height = 2;
  image.step = 4;  // a gap behind each row
  image.encoding = "rgb8";
  image.data = {1, 2, 3, 99, 4, 5, 6, 99};
  auto picture = ToPicture(image);
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_THAT(picture.value().bgr, ElementsAre(3, 2, 1, 6, 5, 4));
  image.encoding = "bgra8";
  EXPECT_THAT(ToPicture(image).value().bgr, ElementsAre(1, 2, 3, 4, 5, 6));
  image.encoding = "mono8";
  EXPECT_THAT(ToPicture(image).value().bgr, ElementsAre(1, 1, 1, 4, 4, 4));
}

TEST(Conversions, RefuseAPictureThatIsNotWhatItSays) {
  msg::Image image;
  image.width = 4'000'000'000;
  image.height = 4'000'000'000;
  image.step = 4'294'967'295;
  image.encoding = "bgr8";
  EXPECT_THAT(ToPicture(image).error().message, HasSubstr("fewer bytes than its size needs"));
  image.width = image.height = 2;
  image.step = 6;
  image.data.resize(11);
  EXPECT_FALSE(ToPicture(image));
  image.data.resize(12);
  EXPECT_TRUE(ToPicture(image));
  image.encoding = "16UC1";
  EXPECT_THAT(ToPicture(image).error().message, HasSubstr("'16UC1'; expected bgr8"));
}

TEST(Conversions, LeaveOutObjectsWithoutAPlace) {
  msg::ObjectStates states;
  states.objects.resize(2);
  states.objects[0].name = "box";
  states.objects[1].pose.position.z = kNan;
  const auto objects = ToObjects(states, {});
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].name, "box");
}

TEST(Conversions, SeeTheLineToTheLeftAsPositive) {
  msg::YellowLines lines;
  EXPECT_FALSE(ToLine(lines, {}));
  lines.contours = 1;
  lines.middle_offset = static_cast<float>(kNan);
  EXPECT_FALSE(ToLine(lines, {}));
  lines.middle_offset = -0.25F;
  lines.edge_x = {0.5F, 0.25F};
  lines.edge_y = {1, 0.5F};
  const auto line = ToLine(lines, {.width_m = 0.8, .depth_m = 0.4});
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->offset_m, 0.2, 1e-6);
  EXPECT_NEAR(line->heading_rad, M_PI / 4, 1e-6);  // 0.2 m to the left, 0.2 m ahead
}

TEST(Conversions, SeeNoLineInAPictureInDoubt) {
  msg::YellowLines lines;
  lines.contours = 1;
  lines.middle_offset = -0.25F;
  ASSERT_TRUE(ToLine(lines, {}));
  lines.doubt = "the floor has the colour of the lines: 98 % of the region";
  EXPECT_FALSE(ToLine(lines, {}));
}

TEST(Conversions, SayWhyANavigationFailed) {
  using Code = msg::ComputePathToPose;
  const navigation::Pose goal{{4, 3, 0}, 0}, high{{4, 3, 5}, 0};
  EXPECT_EQ(PlannerError(Code::kGoalOccupied, goal, {}).message,
            "the goal (4.00, 3.00) has no room for the robot: an obstacle is too near");
  EXPECT_EQ(PlannerError(Code::kStartOccupied, goal, {}).message,
            "the start, the robot's place, has no room for the robot: an obstacle is too near");
  EXPECT_EQ(PlannerError(Code::kStartOutsideMap, goal, high).message,
            "the start (4.00, 3.00, 5.00) is outside the map");
  EXPECT_EQ(PlannerError(Code::kGoalOutsideMap, goal, {}).message,
            "the goal (4.00, 3.00) is outside the map");
  EXPECT_EQ(PlannerError(Code::kGoalOutsideMap, high, {}).message,
            "the goal (4.00, 3.00, 5.00) is outside the map, or above the ceiling");
  const Error walled = PlannerError(Code::kNoValidPath, goal, {});
  EXPECT_EQ(
      walled.message,
      "no path is wide enough for the robot: the goal (4.00, 3.00) or the start is walled in");
  EXPECT_TRUE(navigation::Is(walled, navigation::Fault::kWalledIn));
  const Error no_map = PlannerError(Code::kUnknown, goal, {}, "there is no map yet, on map");
  EXPECT_EQ(no_map.message, "there is no map yet, on map");
  EXPECT_EQ(no_map.code, kCodeStateInvalid) << "it may take the next request";
  EXPECT_EQ(PlannerError(Code::kUnknown, goal, {}).message, "the planner has failed");
  EXPECT_TRUE(navigation::Is(PlannerError(Code::kTfError, goal, {}), navigation::Fault::kOdometry));
  EXPECT_EQ(PlannerError(0, goal, {}).message, "the planner has failed (code 0)");
  EXPECT_EQ(PlannerError(299, goal, {}, "the map is empty").message,
            "the planner has failed (code 299): the map is empty");
  EXPECT_EQ(ControllerError(107).message, "the controller has not answered its server in time");
  EXPECT_TRUE(navigation::Is(ControllerError(107), navigation::Fault::kTimeLimit));
  EXPECT_TRUE(navigation::Is(ControllerError(101), navigation::Fault::kIdentifier));
  EXPECT_TRUE(navigation::Is(ControllerError(103), navigation::Fault::kInput));
  const Error blocked = ControllerError(msg::FollowPath::kPatienceExceeded);
  EXPECT_EQ(blocked.message, "an obstacle stays in the way");
  const Error says_more = ControllerError(msg::FollowPath::kPatienceExceeded, "a box at (1, 2)");
  EXPECT_EQ(says_more.message, "a box at (1, 2)");
  EXPECT_EQ(says_more.code, blocked.code);
  EXPECT_TRUE(navigation::Is(blocked, navigation::Fault::kObstacle));
  EXPECT_FALSE(navigation::Is(ControllerError(msg::FollowPath::kFailedToMakeProgress),
                              navigation::Fault::kObstacle));
}

DetectorView Camera() {
  return {"qr", "/qr/sighting", 0.4, M_PI / 2, {}};
}

msg::Sighting Seen(float x, float width, float distance_m) {
  msg::Sighting sighting;
  sighting.seen = true;
  sighting.x = x;
  sighting.width = width;
  sighting.distance_m = distance_m;
  return sighting;
}

TEST(Conversions, PlaceWhatADetectorHasSeenByItsBoxAndItsDistance) {
  const auto ahead = ToObject(Seen(0.4F, 0.2F, 2), Camera(), {{1, 1, 0}, M_PI / 2});
  ASSERT_TRUE(ahead);
  EXPECT_EQ(ahead->name, "qr");
  EXPECT_EQ(ahead->category, "qr");
  EXPECT_NEAR(ahead->pose.at.x_m, 1, 1e-6);
  EXPECT_NEAR(ahead->pose.at.y_m, 3, 1e-6);
  // At the left edge of a picture of 90 degrees it is 45 degrees to the left.
  const auto left = ToObject(Seen(-0.1F, 0.2F, 2), Camera(), {});
  ASSERT_TRUE(left);
  EXPECT_NEAR(left->pose.at.x_m, std::sqrt(2), 1e-6);
  EXPECT_NEAR(left->pose.at.y_m, std::sqrt(2), 1e-6);
}

TEST(Conversions, FindTheDistanceOfWhatADetectorHasSeenFromItsWidth) {
  // A fifth of a picture of 90 degrees, which shows 2 m at a distance of 1 m: 0.4 m.
  const auto ahead = ToObject(Seen(0.4F, 0.2F, kNan), Camera(), {});
  ASSERT_TRUE(ahead);
  EXPECT_NEAR(ahead->pose.at.x_m, 1, 1e-6);
  const auto left = ToObject(Seen(-0.1F, 0.2F, 0), Camera(), {});
  ASSERT_TRUE(left);
  EXPECT_NEAR(left->pose.at.x_m, 1, 1e-6);
  EXPECT_NEAR(left->pose.at.y_m, 1, 1e-6);
}

TEST(Conversions, LookFromWhereTheCameraIsOnTheBody) {
  DetectorView camera = Camera();
  camera.camera = {{0.2, 0.1, 0.5}, -M_PI / 2};
  msg::Sighting sighting = Seen(0.4F, 0.2F, 2);
  sighting.text = "A-1";
  const auto right = ToObject(sighting, camera, {{0, 0, 0.3}, M_PI / 2});
  ASSERT_TRUE(right);
  EXPECT_EQ(right->name, "A-1");
  EXPECT_EQ(right->category, "qr");
  EXPECT_NEAR(right->pose.at.x_m, -0.1 + 2, 1e-6);
  EXPECT_NEAR(right->pose.at.y_m, 0.2, 1e-6);
  EXPECT_NEAR(right->pose.at.z_m, 0.8, 1e-6);
}

TEST(Conversions, SeeNothingInASightingWithoutABox) {
  msg::Sighting unseen = Seen(0.4F, 0.2F, 2);
  unseen.seen = false;
  EXPECT_FALSE(ToObject(unseen, Camera(), {}));
  for (const float width : {0.F, -1.F, static_cast<float>(kNan)}) {
    EXPECT_FALSE(ToObject(Seen(0.4F, width, 2), Camera(), {}));
  }
  EXPECT_FALSE(ToObject(Seen(1.5F, 0.2F, 2), Camera(), {}));
  EXPECT_FALSE(ToObject(Seen(0.4F, 0.2F, std::numeric_limits<float>::infinity()), Camera(), {}));
}

}  // namespace musher::skills::conversions_test
