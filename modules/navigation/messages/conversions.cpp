#include "musher/modules/navigation/messages/conversions.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/messages/yaw.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr double kLeastLength = 1e-6;  // of a quaternion
constexpr std::size_t kLongestName = 40;

// Printable and short: the text comes from outside.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char letter : text.substr(0, kLongestName)) {
    quoted += letter >= ' ' && letter <= '~' ? letter : '?';
  }
  return quoted + "'";
}

Result<> CheckFrame(const std::string& found, const std::string& expected,
                    const std::string& what) {
  if (found.empty() || found == expected) return Ok();
  return MakeError(Fault::kFrame, fmt::format("{}: its frame is {}, expected {}", what,
                                              Quoted(found), Quoted(expected)));
}

// One of the fields x, y, z of a point.
struct Coordinate {
  std::size_t offset = 0;
  bool is_double = false;

  double Of(const std::uint8_t* point) const {
    if (is_double) {
      double value = 0;
      std::memcpy(&value, point + offset, sizeof value);
      return value;
    }
    float value = 0;
    std::memcpy(&value, point + offset, sizeof value);
    return value;
  }
};

Result<Coordinate> CoordinateOf(const msg::PointCloud2& cloud, const std::string& name) {
  for (const msg::PointField& field : cloud.fields) {
    if (field.name != name) continue;
    const bool is_double = field.datatype == msg::PointField::kFloat64;
    if (!is_double && field.datatype != msg::PointField::kFloat32) {
      return MakeError(Fault::kMap,
                       fmt::format("point cloud: field {} has datatype {}, expected FLOAT32 (7) or "
                                   "FLOAT64 (8)",
                                   name, field.datatype));
    }
    const std::size_t size = is_double ? sizeof(double) : sizeof(float);
    if (std::size_t{field.offset} + size > cloud.point_step) {
      return MakeError(Fault::kMap,
                       fmt::format("point cloud: field {} ends at byte {}, a point has {}", name,
                                   std::size_t{field.offset} + size, cloud.point_step));
    }
    return Coordinate{field.offset, is_double};
  }
  return MakeError(Fault::kMap, fmt::format("point cloud: it has no field {}", name));
}

Result<> CheckSizes(const msg::PointCloud2& cloud) {
  if (cloud.is_bigendian) {
    return MakeError(Fault::kMap, "point cloud: it is big-endian, expected little-endian");
  }
  const std::uint64_t count = std::uint64_t{cloud.width} * cloud.height;
  if (count == 0 || cloud.point_step == 0) {
    return MakeError(Fault::kMap, "point cloud: it has no points");
  }
  if (count > kMostCloudPoints) {
    return MakeError(Fault::kMap, fmt::format("point cloud: it has {} points, at most {}", count,
                                              kMostCloudPoints));
  }
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  if (cloud.row_step < row) {
    return MakeError(Fault::kMap,
                     fmt::format("point cloud: row_step is {}, expected {} x {} or more",
                                 cloud.row_step, cloud.width, cloud.point_step));
  }
  const std::uint64_t bytes = std::uint64_t{cloud.row_step} * cloud.height;
  if (cloud.data.size() != bytes) {
    return MakeError(Fault::kMap, fmt::format("point cloud: it has {} bytes, expected {} x {}",
                                              cloud.data.size(), cloud.height, cloud.row_step));
  }
  return Ok();
}

std::vector<double> ListOf(const Velocity& velocity) {
  return {velocity.x_m_s, velocity.y_m_s, velocity.z_m_s, velocity.yaw_rad_s};
}

}  // namespace

Result<Pose> ToPose(const msg::Pose& pose, const std::string& what) {
  const auto& at = pose.position;
  const auto& turn = pose.orientation;
  const double square = turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + turn.w * turn.w;
  const Point place{at.x, at.y, at.z};
  if (!IsFinite(place) || !std::isfinite(square)) {
    return MakeError(Fault::kInput, what + ": it has a number that is not finite");
  }
  if (square < kLeastLength) {
    return MakeError(Fault::kInput, what +
                                        ": its orientation is (0, 0, 0, 0), expected a "
                                        "quaternion of length 1");
  }
  return Pose{place, msg::YawOf(turn)};
}

Result<Pose> ToPose(const msg::PoseStamped& pose, const std::string& frame,
                    const std::string& what) {
  if (auto checked = CheckFrame(pose.header.frame_id, frame, what); !checked) {
    return checked.error();
  }
  return ToPose(pose.pose, what);
}

msg::Pose ToMessage(const Pose& pose) {
  msg::Pose message;
  message.position = {pose.at.x_m, pose.at.y_m, pose.at.z_m};
  message.orientation = msg::FromYaw(pose.yaw_rad);
  return message;
}

Result<Path> ToPath(const msg::Path& path, const std::string& frame) {
  if (auto checked = CheckFrame(path.header.frame_id, frame, "path"); !checked) {
    return checked.error();
  }
  if (path.poses.empty()) return MakeError(Fault::kInput, "path: it has no pose");
  Path poses;
  poses.reserve(path.poses.size());
  for (const msg::PoseStamped& stamped : path.poses) {
    auto pose = ToPose(stamped, frame,
                       fmt::format("path: pose {} of {}", poses.size() + 1, path.poses.size()));
    if (!pose) return pose.error();
    poses.push_back(pose.value());
  }
  return poses;
}

msg::Path ToMessage(const Path& path, const msg::Header& header) {
  msg::Path message;
  message.header = header;
  message.poses.reserve(path.size());
  for (const Pose& pose : path) message.poses.push_back({header, ToMessage(pose)});
  return message;
}

msg::JointTrajectory ToMessage(const Trajectory& trajectory, const msg::Header& header) {
  msg::JointTrajectory message;
  message.header = header;
  message.joint_names = {"x", "y", "z", "yaw"};
  message.points.reserve(trajectory.points.size());
  for (const TrajectoryPoint& point : trajectory.points) {
    const auto since = kTrajectoryStep * static_cast<std::int64_t>(message.points.size());
    const msg::Stamp time = msg::ToStamp(since);
    const Pose& pose = point.pose;
    message.points.push_back({{pose.at.x_m, pose.at.y_m, pose.at.z_m, pose.yaw_rad},
                              ListOf(point.velocity),
                              ListOf(point.acceleration),
                              {},
                              {time.sec, time.nanosec}});
  }
  return message;
}

Result<Motion> ToMotion(const msg::Odometry& odometry, const std::string& frame,
                        const FrameTree& frames, Time now) {
  auto pose = ToPose(odometry.pose.pose, "odometry");
  if (!pose) return pose.error();
  const std::string& own = odometry.header.frame_id;
  if (!own.empty() && own != frame) {
    const auto placed = frames.Find(frame, own, now);
    if (!placed) {
      return MakeError(Fault::kFrame,
                       fmt::format("odometry: its frame is {}, expected {} or a transform: {}",
                                   Quoted(own), Quoted(frame), placed.error().message));
    }
    if (placed.value().upside_down) {
      return MakeError(Fault::kFrame, "odometry: its frame is upside down in the map");
    }
    pose = PlacedAt(placed.value().pose, pose.value());
  }
  const msg::Vector3& v = odometry.twist.twist.linear;
  const double yaw_rate = odometry.twist.twist.angular.z;
  if (!IsFinite(Point{v.x, v.y, v.z}) || !std::isfinite(yaw_rate)) {
    return MakeError(Fault::kInput, "odometry: its twist has a number that is not finite");
  }
  // Turned the other way round.
  const Velocity velocity = InBodyFrame({v.x, v.y, v.z, yaw_rate}, -pose.value().yaw_rad);
  return Motion{pose.value(), velocity};
}

Result<RobotIntent> ToIntent(const msg::RobotPath& path, const std::string& frame) {
  const std::string what = "the path of " + Quoted(path.robot);
  if (auto checked = CheckFrame(path.header.frame_id, frame, what); !checked) {
    return checked.error();
  }
  const auto pose = ToPose(path.pose, what);
  if (!pose) return pose.error();
  RobotIntent intent{.robot = path.robot,
                     .priority = path.priority,
                     .radius_m = path.radius_m,
                     .flies = path.flies,
                     .cornered = path.cornered,
                     .at = pose.value().at,
                     .path = {}};
  for (const msg::Point& point : path.path) {
    intent.path.push_back({point.x, point.y, point.z});
    if (IsFinite(intent.path.back())) continue;
    return MakeError(Fault::kInput, what + ": a number is not finite");
  }
  if (std::isfinite(path.radius_m) && path.radius_m >= 0) return intent;
  return MakeError(Fault::kInput, what + ": its radius is not a length");
}

Scan ToScan(const msg::LaserScan& scan) {
  return {scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, scan.ranges};
}

DownReading ToReading(const msg::Range& range) {
  return {range.range, range.min_range, range.max_range, range.field_of_view};
}

Result<OccupancyGrid> ToGrid(const msg::OccupancyGrid& grid, const std::string& frame) {
  if (auto checked = CheckFrame(grid.header.frame_id, frame, "map"); !checked) {
    return checked.error();
  }
  auto origin = ToPose(grid.info.origin, "map: origin");
  if (!origin) return MakeError(Fault::kMap, origin.error().message);
  const std::uint64_t cells = std::uint64_t{grid.info.width} * grid.info.height;
  if (grid.data.size() != cells) {
    return MakeError(Fault::kMap, fmt::format("map: it has {} cells, expected {} x {}",
                                              grid.data.size(), grid.info.width, grid.info.height));
  }
  return OccupancyGrid{grid.info.resolution, origin.value(), grid.info.width, grid.info.height,
                       grid.data};
}

Result<std::vector<Point>> ToPoints(const msg::PointCloud2& cloud, const std::string& frame) {
  Result<> checked = CheckFrame(cloud.header.frame_id, frame, "point cloud");
  if (checked) checked = CheckSizes(cloud);
  if (!checked) return checked.error();
  std::array<Coordinate, 3> coordinates;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto found = CoordinateOf(cloud, std::string(1, static_cast<char>('x' + axis)));
    if (!found) return found.error();
    coordinates[axis] = found.value();
  }
  std::vector<Point> points;
  points.reserve(std::size_t{cloud.width} * cloud.height);
  for (std::size_t row = 0; row < cloud.height; ++row) {
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const std::uint8_t* at = cloud.data.data() + row * cloud.row_step + column * cloud.point_step;
      const Point point{coordinates[0].Of(at), coordinates[1].Of(at), coordinates[2].Of(at)};
      if (IsFinite(point)) {
        points.push_back(point);
      } else if (cloud.is_dense) {
        return MakeError(Fault::kMap,
                         fmt::format("point cloud: point {} is not finite, although it is dense",
                                     row * cloud.width + column));
      }
    }
  }
  if (points.empty()) return MakeError(Fault::kMap, "point cloud: no point is finite");
  return points;
}

}  // namespace musher::navigation
