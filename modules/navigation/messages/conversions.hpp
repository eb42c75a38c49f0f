#pragma once
// Between ROS 2's messages and the values of the navigation chain. Metres, radians, the frame of
// the map; an empty frame of a message counts as that. Numbers that are not finite, orientations
// without a length, other frames and sizes that do not fit are refused with Fault::kInput, kFrame
// or kMap; the message says which value, and what was expected. Pure; any thread.

#include <string>
#include <vector>

#include "musher/messages/musher_msgs/robot_path.hpp"
#include "musher/messages/nav_msgs/occupancy_grid.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/nav_msgs/path.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/point_cloud2.hpp"
#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/messages/trajectory_msgs/joint_trajectory.hpp"
#include "musher/navigation/controller/obstacle_watch.hpp"
#include "musher/navigation/frames/frame_tree.hpp"
#include "musher/navigation/gate/descent_watch.hpp"
#include "musher/navigation/planner/cell_map.hpp"
#include "musher/navigation/traffic/right_of_way.hpp"

namespace musher::navigation {

inline constexpr std::size_t kMostCloudPoints = 5'000'000;

// Of a body: both in the frame of the map.
struct Motion {
  Pose pose;
  Velocity velocity;
};

// `what` names the pose in errors: "goal".
Result<Pose> ToPose(const msg::Pose& pose, const std::string& what);
Result<Pose> ToPose(const msg::PoseStamped& pose, const std::string& frame,
                    const std::string& what);
msg::Pose ToMessage(const Pose& pose);

// The poses have the frame of the path, or none.
Result<Path> ToPath(const msg::Path& path, const std::string& frame);
msg::Path ToMessage(const Path& path, const msg::Header& header);

// Joints x, y, z and yaw.
msg::JointTrajectory ToMessage(const Trajectory& trajectory, const msg::Header& header);

// The twist of the message is in the frame of the body. A pose in another frame than the map's, as
// `odom`, is placed in the map by `frames`; without a transform it is refused with Fault::kFrame.
Result<Motion> ToMotion(const msg::Odometry& odometry, const std::string& frame,
                        const FrameTree& frames, Time now);

// Where another robot is, and what it drives.
Result<RobotIntent> ToIntent(const msg::RobotPath& path, const std::string& frame);

Scan ToScan(const msg::LaserScan& scan);
DownReading ToReading(const msg::Range& range);

Result<OccupancyGrid> ToGrid(const msg::OccupancyGrid& grid, const std::string& frame);

// The fields x, y and z, of FLOAT32 or FLOAT64. Points that are not finite are left out of a cloud
// that is not dense; in a dense one they are refused.
Result<std::vector<Point>> ToPoints(const msg::PointCloud2& cloud, const std::string& frame);

}  // namespace musher::navigation
