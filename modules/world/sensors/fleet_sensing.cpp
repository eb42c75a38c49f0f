#include "musher/modules/world/sensors/fleet_sensing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "musher/messages/stamp.hpp"
#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/sensors/ranging.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kCellM = 0.05;
constexpr double kPointsEveryM = 0.08;
constexpr std::int8_t kOccupied = 100;

NormalRandom RobotRandom(const World& world, std::size_t robot) {
  constexpr std::uint64_t kFleetLidar = 1000;
  transport::sim::Random seed(world.scene().seed);
  transport::sim::Random of_robot(seed.Next() + kFleetLidar + robot);
  return NormalRandom(of_robot.Next() + static_cast<std::uint64_t>(world.now().count()));
}

class Cloud {
 public:
  // Points on the rectangle from `corner` along two edges, both ends included.
  void AddFace(const Vector3d& corner, const Vector3d& along, const Vector3d& across) {
    const int columns = Steps(along.norm());
    const int rows = Steps(across.norm());
    for (int row = 0; row <= rows; ++row) {
      for (int column = 0; column <= columns; ++column) {
        Add(corner + along * column / columns + across * row / rows);
      }
    }
  }

  void AddBox(const Box& box) {
    const Rotation2Dd turn(box.yaw_rad);
    const auto flat = [&](double x, double y) {
      const Vector2d turned = turn * Vector2d(x, y);
      return Vector3d(turned.x(), turned.y(), 0);
    };
    const Vector3d length = flat(2 * box.half_m.x(), 0);
    const Vector3d width = flat(0, 2 * box.half_m.y());
    const Vector3d up(0, 0, box.height_m);
    const Vector3d corner =
        Vector3d(box.center_m.x(), box.center_m.y(), box.bottom_m) - (length + width) / 2;
    AddFace(corner, length, up);
    AddFace(corner + width, length, up);
    AddFace(corner, width, up);
    AddFace(corner + length, width, up);
    AddFace(corner, length, width);
    AddFace(corner + up, length, width);
  }

  void AddCircle(const Circle& circle) {
    const int around = std::max(8, Steps(2 * M_PI * circle.radius_m));
    const int rings = Steps(circle.radius_m);
    const int rows = Steps(circle.height_m);
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * M_PI * i / around;
      const Vector3d out(circle.radius_m * std::cos(angle), circle.radius_m * std::sin(angle), 0);
      const Vector3d foot(circle.center_m.x(), circle.center_m.y(), circle.bottom_m);
      for (int row = 0; row <= rows; ++row) {
        Add(foot + out + Vector3d(0, 0, circle.height_m * row / rows));
      }
      for (int ring = 0; ring < rings; ++ring) {
        Add(foot + out * ring / rings);
        Add(foot + out * ring / rings + Vector3d(0, 0, circle.height_m));
      }
    }
  }

  const std::vector<Vector3f>& points() const { return points_; }

 private:
  static int Steps(double length_m) {
    return std::max(1, static_cast<int>(std::ceil(length_m / kPointsEveryM)));
  }
  void Add(const Vector3d& point) { points_.emplace_back(point.cast<float>()); }

  std::vector<Vector3f> points_;
};

msg::PointField FieldOf(const char* name, std::uint32_t offset) {
  msg::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = msg::PointField::kFloat32;
  field.count = 1;
  return field;
}

}  // namespace

Scene SceneAround(const World& world, std::size_t robot) {
  Scene scene;
  const Scene& of = world.scene();
  scene.least_m = of.least_m;
  scene.most_m = of.most_m;
  scene.fence_height_m = of.fence_height_m;
  scene.boxes = of.boxes;
  scene.circles = of.circles;
  scene.boards = of.boards;
  scene.balls = of.balls;
  std::vector<Solid> moving = world.fleet().MovingSolids(of, robot);
  const std::vector<Solid> body = world.BodySolid();
  moving.insert(moving.end(), body.begin(), body.end());
  for (const Solid& solid : moving) {
    if (const auto* box = std::get_if<Box>(&solid.shape)) scene.boxes.push_back(*box);
    if (const auto* circle = std::get_if<Circle>(&solid.shape)) scene.circles.push_back(*circle);
  }
  return scene;
}

msg::LaserScan MeasureRobotScan(const World& world, std::size_t robot) {
  const RobotSpec& spec = world.scene().robots.at(robot);
  const LidarSpec& lidar = spec.lidar;
  const RobotBody& body = world.fleet().robots()[robot].body;
  const Reach& reach = lidar.reach;
  Vector3d mount = lidar.mount.position_m;
  mount.head<2>() = Rotation2Dd(body.yaw_rad()) * Vector2d(mount.head<2>());
  const RayTargets around(SceneAround(world, robot), body.position_m() + mount, RayLength(reach));
  NormalRandom random = RobotRandom(world, robot);
  const double step = (lidar.to_rad - lidar.from_rad) / (lidar.rays - 1);
  msg::LaserScan scan;
  scan.header = {msg::ToStamp(world.now()), spec.name};
  scan.angle_min = static_cast<float>(lidar.from_rad);
  scan.angle_max = static_cast<float>(lidar.to_rad);
  scan.angle_increment = static_cast<float>(step);
  scan.scan_time = static_cast<float>(1 / reach.rate_hz);
  scan.range_min = static_cast<float>(reach.least_m);
  scan.range_max = static_cast<float>(reach.most_m);
  scan.ranges.reserve(static_cast<std::size_t>(lidar.rays));
  for (int i = 0; i < lidar.rays; ++i) {
    const double yaw = body.yaw_rad() + lidar.mount.yaw_rad + lidar.from_rad + i * step;
    const double distance = around.DistanceAlong({std::cos(yaw), std::sin(yaw), 0});
    scan.ranges.push_back(static_cast<float>(Reading(reach, distance, random)));
  }
  return scan;
}

msg::Range MeasureRobotRange(const World& world, std::size_t robot) {
  constexpr int kRings = 4, kRaysARing = 6;  // around the ray in the middle; more from ring to ring
  const RobotSpec& spec = world.scene().robots.at(robot);
  const RangeDownSpec& sensor = spec.range_down.value();
  const Reach& reach = sensor.reach;
  const RobotBody& body = world.fleet().robots()[robot].body;
  Vector3d mount = sensor.position_m;
  mount.head<2>() = Rotation2Dd(body.yaw_rad()) * Vector2d(mount.head<2>());
  const RayTargets around(SceneAround(world, robot), body.position_m() + mount, RayLength(reach));
  double nearest = around.DistanceAlong({0, 0, -1});
  for (int ring = 1; ring <= kRings; ++ring) {
    const double off = sensor.cone_rad / 2 * ring / kRings;
    for (int i = 0; i < kRaysARing * ring; ++i) {
      const double turn = 2 * M_PI * i / (kRaysARing * ring);
      nearest =
          std::min(nearest, around.DistanceAlong({std::sin(off) * std::cos(turn),
                                                  std::sin(off) * std::sin(turn), -std::cos(off)}));
    }
  }
  NormalRandom random = RobotRandom(world, robot);
  msg::Range range;
  range.header = {msg::ToStamp(world.now()), spec.name + "/range_down"};
  range.radiation_type = msg::Range::kInfrared;
  range.field_of_view = static_cast<float>(sensor.cone_rad);
  range.min_range = static_cast<float>(reach.least_m);
  range.max_range = static_cast<float>(reach.most_m);
  range.range = static_cast<float>(Reading(reach, nearest, random));
  range.variance = static_cast<float>(reach.noise_m * reach.noise_m);
  return range;
}

double TallestOnGround(const Scene& scene) {
  double tallest = 0;
  for (const RobotSpec& robot : scene.robots) {
    if (robot.kind != RobotKind::kFlyer) tallest = std::max(tallest, robot.height_m);
  }
  return tallest > 0 ? tallest : scene.body.stand_height_m;
}

msg::OccupancyGrid MapOfGround(const Scene& scene, double height_m) {
  msg::OccupancyGrid grid;
  grid.header.frame_id = kMapFrame;
  const Vector2d size = scene.most_m - scene.least_m;
  grid.info.resolution = static_cast<float>(kCellM);
  grid.info.width = static_cast<std::uint32_t>(std::ceil(size.x() / kCellM - 1e-9));
  grid.info.height = static_cast<std::uint32_t>(std::ceil(size.y() / kCellM - 1e-9));
  grid.info.origin.position = {scene.least_m.x(), scene.least_m.y(), 0};
  grid.data.assign(std::size_t(grid.info.width) * grid.info.height, 0);
  constexpr double kReachM = kCellM / 2 - 1e-6;  // from the middle of a cell to its sides
  const Vector2d corner = scene.least_m;
  for (const Solid& solid : SolidsOf(scene)) {
    if (BottomOf(solid) >= height_m) continue;
    std::size_t index = 0;
    for (std::uint32_t row = 0; row < grid.info.height; ++row) {
      for (std::uint32_t column = 0; column < grid.info.width; ++column, ++index) {
        const Vector2d middle = corner + Vector2d(column + 0.5, row + 0.5) * kCellM;
        if (DistanceTo(solid, middle) < kReachM) grid.data[index] = kOccupied;
      }
    }
  }
  for (std::uint32_t row = 0; row < grid.info.height; ++row) {
    for (std::uint32_t column = 0; column < grid.info.width; ++column) {
      const bool edge =
          row == 0 || column == 0 || row + 1 == grid.info.height || column + 1 == grid.info.width;
      if (edge) grid.data[std::size_t(row) * grid.info.width + column] = kOccupied;
    }
  }
  return grid;
}

msg::PointCloud2 CloudOfSurfaces(const Scene& scene) {
  Cloud cloud;
  const Vector3d corner(scene.least_m.x(), scene.least_m.y(), 0);
  const Vector3d along(scene.most_m.x() - scene.least_m.x(), 0, 0);
  const Vector3d across(0, scene.most_m.y() - scene.least_m.y(), 0);
  cloud.AddFace(corner, along, across);
  if (scene.ceiling_m > 0) {
    cloud.AddFace(corner + Vector3d(0, 0, scene.ceiling_m), along, across);
  }
  const Vector3d up(0, 0, scene.ceiling_m > 0 ? scene.ceiling_m : scene.fence_height_m);
  if (up.z() > 0) {
    cloud.AddFace(corner, along, up);
    cloud.AddFace(corner + across, along, up);
    cloud.AddFace(corner, across, up);
    cloud.AddFace(corner + along, across, up);
  }
  for (const Solid& solid : SolidsOf(scene)) {
    if (const auto* box = std::get_if<Box>(&solid.shape)) cloud.AddBox(*box);
    if (const auto* circle = std::get_if<Circle>(&solid.shape)) cloud.AddCircle(*circle);
  }
  msg::PointCloud2 message;
  message.header.frame_id = kMapFrame;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(cloud.points().size());
  message.fields = {FieldOf("x", 0), FieldOf("y", 4), FieldOf("z", 8)};
  message.point_step = 3 * sizeof(float);
  message.row_step = message.point_step * message.width;
  message.data.resize(message.row_step);
  std::uint8_t* next = message.data.data();
  for (const auto& point : cloud.points()) {
    std::memcpy(next, point.data(), message.point_step);
    next += message.point_step;
  }
  message.is_dense = true;
  return message;
}

}  // namespace musher::world
