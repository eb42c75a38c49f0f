// Messages of ROS 2 as values of the navigation chain, and what is refused of them.

#include "musher/modules/navigation/messages/conversions.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation::conversions_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Points (i, 2 i, 3 i) of floats, with `gap` bytes behind each point and each row.
msg::PointCloud2 Cloud(std::uint32_t width, std::uint32_t height = 1, std::uint32_t gap = 0) {
  msg::PointCloud2 cloud;
  cloud.header.frame_id = "map";
  cloud.width = width;
  cloud.height = height;
  cloud.point_step = 12 + gap;
  cloud.row_step = width * cloud.point_step + gap;
  cloud.fields = {{"x", 0, msg::PointField::kFloat32, 1},
                  {"y", 4, msg::PointField::kFloat32, 1},
                  {"z", 8, msg::PointField::kFloat32, 1}};
  cloud.data.resize(std::size_t{cloud.row_step} * height);
  for (std::uint32_t i = 0; i < width * height; ++i) {
    const auto value = static_cast<float>(i);
    const float point[3] = {value, 2 * value, 3 * value};
    const std::size_t at = i / width * cloud.row_step + i % width * cloud.point_step;
    std::memcpy(cloud.data.data() + at, point, sizeof point);
  }
  cloud.is_dense = true;
  return cloud;
}

std::string WhyNot(const std::function<void(msg::PointCloud2&)>& change) {
  msg::PointCloud2 cloud = Cloud(4, 2);
  change(cloud);
  const auto points = ToPoints(cloud, "map");
  return points ? "" : points.error().message;
}

void SetX(msg::PointCloud2& cloud, std::size_t index, float x) {
  std::memcpy(cloud.data.data() + index * cloud.point_step, &x, sizeof x);
}

TEST(ToPoints, ReadsRowsWithGaps) {
  const auto points = ToPoints(Cloud(3, 2, 4), "map");
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points.value().size(), 6U);
  EXPECT_EQ(points.value()[5], (Point{5, 10, 15}));
}

TEST(ToPoints, ReadsDoublesInAnyOrder) {
  msg::PointCloud2 cloud;
  cloud.width = cloud.height = 1;
  cloud.point_step = cloud.row_step = 24;
  cloud.fields = {{"z", 0, msg::PointField::kFloat64, 1},
                  {"y", 8, msg::PointField::kFloat64, 1},
                  {"x", 16, msg::PointField::kFloat64, 1}};
  const double values[3] = {3, 2, 1};
  cloud.data.resize(sizeof values);
  std::memcpy(cloud.data.data(), values, sizeof values);
  const auto points = ToPoints(cloud, "map");
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_THAT(points.value(), ElementsAre(Point{1, 2, 3}));
}

TEST(ToPoints, RefusesAMalformedCloudWithTheReason) {
  EXPECT_EQ(WhyNot([](auto&) {}), "");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.fields.pop_back(); }), "point cloud: it has no field z");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.point_step = 8; }),
            "point cloud: field z ends at byte 12, a point has 8");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.fields[1].offset = 0xFFFFFFFF; }),
            "point cloud: field y ends at byte 4294967299, a point has 12");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.point_step = 0; }), "point cloud: it has no points");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.width = 0; }), "point cloud: it has no points");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.row_step = 47; }),
            "point cloud: row_step is 47, expected 4 x 12 or more");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.data.pop_back(); }),
            "point cloud: it has 95 bytes, expected 2 x 48");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.height = 0xFFFFFFFF; }),
            "point cloud: it has 17179869180 points, at most 5000000");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.fields[0].datatype = 2; }),
            "point cloud: field x has datatype 2, expected FLOAT32 (7) or FLOAT64 (8)");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.is_bigendian = true; }),
            "point cloud: it is big-endian, expected little-endian");
  EXPECT_EQ(WhyNot([](auto& cloud) { cloud.header.frame_id = "odom\n"; }),
            "point cloud: its frame is 'odom?', expected 'map'");
}

TEST(ToPoints, LeavesOutPointsThatAreNotFiniteOnlyOfACloudThatIsNotDense) {
  msg::PointCloud2 cloud = Cloud(3);
  SetX(cloud, 1, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(ToPoints(cloud, "map").error().message,
            "point cloud: point 1 is not finite, although it is dense");
  cloud.is_dense = false;
  EXPECT_EQ(ToPoints(cloud, "map").value().size(), 2U);
  SetX(cloud, 0, std::numeric_limits<float>::infinity());
  SetX(cloud, 2, std::numeric_limits<float>::infinity());
  EXPECT_EQ(ToPoints(cloud, "map").error().message, "point cloud: no point is finite");
}

TEST(ToPose, RefusesNumbersThatAreNotFiniteAndOrientationsWithoutALength) {
  msg::PoseStamped pose;
  pose.header.frame_id = "map";
  EXPECT_TRUE(ToPose(pose, "map", "goal"));
  pose.pose.orientation = {0, 0, 0, 0};
  EXPECT_THAT(ToPose(pose, "map", "goal").error().message,
              HasSubstr("goal: its orientation is (0, 0, 0, 0)"));
  pose.pose.orientation = {0, 0, kNan, 1};
  EXPECT_THAT(ToPose(pose, "map", "goal").error().message, HasSubstr("not finite"));
  pose.pose.orientation = {0, 0, 1e200, 1};
  EXPECT_THAT(ToPose(pose, "map", "goal").error().message, HasSubstr("not finite"));
  pose.pose.orientation = {};
  pose.pose.position.y = kNan;
  EXPECT_THAT(ToPose(pose, "map", "goal").error().message, HasSubstr("not finite"));
}

TEST(ToPose, RefusesAnotherFrame) {
  msg::PoseStamped pose;
  EXPECT_TRUE(ToPose(pose, "map", "goal")) << "no frame is that of the map";
  pose.header.frame_id = "odom";
  const auto refused = ToPose(pose, "map", "goal");
  ASSERT_FALSE(refused);
  EXPECT_TRUE(Is(refused.error(), Fault::kFrame));
  EXPECT_EQ(refused.error().message, "goal: its frame is 'odom', expected 'map'");
}

TEST(ToPose, HasTheYawOfAnOrientationOfAnyLength) {
  msg::Pose pose = ToMessage(Pose{{1, 2, 3}, 2.5});
  EXPECT_NEAR(ToPose(pose, "goal").value().yaw_rad, 2.5, 1e-12);
  pose.orientation.z *= 3;
  pose.orientation.w *= 3;
  EXPECT_NEAR(ToPose(pose, "goal").value().yaw_rad, 2.5, 1e-12);
}

TEST(ToPath, NamesThePoseThatIsRefused) {
  const msg::Path path = ToMessage(Path{{{1, 2, 0}, 0.5}, {{3, 4, 0}, 1}}, {});
  const auto poses = ToPath(path, "map");
  ASSERT_TRUE(poses);
  EXPECT_EQ(poses.value()[1].at, (Point{3, 4, 0}));
  msg::Path bad = path;
  bad.poses[1].pose.position.x = kNan;
  EXPECT_EQ(ToPath(bad, "map").error().message,
            "path: pose 2 of 2: it has a number that is not finite");
  EXPECT_EQ(ToPath({}, "map").error().message, "path: it has no pose");
}

// As localisations of ROS 2 have it: odometry in a frame of its own, which /tf places in the map.
TEST(ToMotion, PlacesAPoseOfAnotherFrameByTf) {
  const Time now = Time{} + std::chrono::seconds(10);
  FrameTree frames(std::chrono::seconds(1));
  msg::Odometry odometry;
  odometry.header.frame_id = "odom";
  odometry.pose.pose = ToMessage(Pose{{2, 0, 0}, 0});
  odometry.twist.twist.linear.x = 1;
  const auto refused = ToMotion(odometry, "map", frames, now);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(Is(refused.error(), Fault::kFrame));
  EXPECT_EQ(refused.error().message,
            "odometry: its frame is 'odom', expected 'map' or a transform: no transform from map "
            "to odom: odom has no known parent");
  const double half = std::sqrt(0.5);
  ASSERT_TRUE(frames.Set("map", "odom", {{1, 1, 0}, 0, 0, half, half}, false, now));
  const auto motion = ToMotion(odometry, "map", frames, now);
  ASSERT_TRUE(motion) << motion.error().message;
  EXPECT_NEAR(motion.value().pose.at.x_m, 1, 1e-9);
  EXPECT_NEAR(motion.value().pose.at.y_m, 3, 1e-9);
  EXPECT_NEAR(motion.value().pose.yaw_rad, M_PI / 2, 1e-9);
  EXPECT_NEAR(motion.value().velocity.y_m_s, 1, 1e-9);
  EXPECT_FALSE(ToMotion(odometry, "map", frames, now + std::chrono::seconds(2))) << "it is old";
}

TEST(ToMotion, TurnsTheVelocityIntoTheFrameOfTheMap) {
  const FrameTree frames(std::chrono::seconds(1));
  const Time now{};
  msg::Odometry odometry;
  odometry.header.frame_id = "map";
  odometry.pose.pose = ToMessage(Pose{{1, 2, 0}, M_PI / 2});
  odometry.twist.twist.linear = {1, 0.5, 0.2};
  odometry.twist.twist.angular.z = 0.3;
  const auto motion = ToMotion(odometry, "map", frames, now);
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion.value().velocity.x_m_s, -0.5, 1e-12);
  EXPECT_NEAR(motion.value().velocity.y_m_s, 1, 1e-12);
  EXPECT_NEAR(motion.value().velocity.z_m_s, 0.2, 1e-12);
  EXPECT_NEAR(motion.value().velocity.yaw_rad_s, 0.3, 1e-12);
  odometry.twist.twist.linear.x = kNan;
  EXPECT_FALSE(ToMotion(odometry, "map", frames, now));
}

TEST(ToGrid, RefusesAGridWhoseSizeDoesNotFit) {
  msg::OccupancyGrid grid;
  grid.header.frame_id = "map";
  grid.info.resolution = 0.05F;
  grid.info.width = 3;
  grid.info.height = 2;
  grid.data = {0, 0, 100, 0, -1, 0};
  ASSERT_TRUE(ToGrid(grid, "map"));
  EXPECT_EQ(ToGrid(grid, "map").value().data[2], 100);
  msg::OccupancyGrid bad = grid;
  bad.info.width = 0x80000000;
  bad.info.height = 2;
  EXPECT_EQ(ToGrid(bad, "map").error().message, "map: it has 6 cells, expected 2147483648 x 2");
  bad = grid;
  bad.info.origin.orientation = {0, 0, 0, 0};
  EXPECT_THAT(ToGrid(bad, "map").error().message, HasSubstr("map: origin: its orientation"));
  bad = grid;
  bad.header.frame_id = "world";
  EXPECT_FALSE(ToGrid(bad, "map"));
}

TEST(TrajectoryMessage, HasTheJointsOfABodyAndTimesFromItsStart) {
  const auto trajectory = MakeTrajectory({{{0, 0, 0}, 0}, {{1, 0, 0}, 0}}, {}).value();
  const msg::JointTrajectory message = ToMessage(trajectory, msg::Header{});
  EXPECT_THAT(message.joint_names, ElementsAre("x", "y", "z", "yaw"));
  ASSERT_EQ(message.points.size(), trajectory.points.size());
  EXPECT_EQ(message.points[51].time_from_start.sec, 1);
  EXPECT_EQ(message.points[51].time_from_start.nanosec, 20'000'000U);
  EXPECT_THAT(message.points.back().velocities, ElementsAre(0, 0, 0, 0));
  EXPECT_EQ(message.points[51].accelerations.size(), 4U);
}

}  // namespace musher::navigation::conversions_test
