#include "musher/modules/world/process/robot_messages.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/messages/yaw.hpp"
#include "musher/modules/world/sensors/fleet_sensing.hpp"
#include "musher/modules/world/sensors/object_sight.hpp"

namespace musher::world {
namespace {

using Eigen::Vector3d;

msg::Pose PoseOf(const Vector3d& position_m, double yaw_rad) {
  msg::Pose pose;
  pose.position = {position_m.x(), position_m.y(), position_m.z()};
  pose.orientation = msg::FromYaw(yaw_rad);
  return pose;
}

msg::Odometry OdometryOf(const std::string& name, Duration at, const msg::Pose& pose,
                         const BodyVelocity& velocity) {
  msg::Odometry odometry;
  odometry.header = {msg::ToStamp(at), kMapFrame};
  odometry.child_frame_id = name;
  odometry.pose.pose = pose;
  const Vector3d& linear = velocity.linear_m_s;
  odometry.twist.twist.linear = {linear.x(), linear.y(), linear.z()};
  odometry.twist.twist.angular.z = velocity.turn_rad_s;
  return odometry;
}

}  // namespace

msg::Odometry OdometryOfRobot(const World& world, std::size_t robot) {
  const RobotBody& body = world.fleet().robots().at(robot).body;
  return OdometryOf(world.scene().robots[robot].name, world.now(),
                    PoseOf(body.position_m(), body.yaw_rad()), body.velocity());
}

Result<OdometryFault> OdometryFaultFrom(const std::string& text) {
  OdometryFault fault;
  std::istringstream words(text);
  std::string kind, more;
  words >> kind;
  if (kind == "jump") words >> fault.off_m.x() >> fault.off_m.y();
  fault.freezes = kind == "freeze";
  const bool known = fault.freezes || kind == "jump" || kind == "right";
  if (!known || words.fail() || words >> more || !fault.off_m.allFinite()) {
    return Error{kCodeParametersInvalid, "odometry: expected freeze, jump X Y or right, found \"" +
                                             text.substr(0, 60) + "\""};
  }
  return fault;
}

msg::Odometry OdometryOfMover(const World& world, std::size_t index) {
  const Mover& mover = world.fleet().movers().at(index);
  const Vector3d at(mover.position_m().x(), mover.position_m().y(), 0);
  return OdometryOf(world.scene().movers[index].name, world.now(), PoseOf(at, mover.yaw_rad()),
                    {{mover.speed_m_s(), 0, 0}, 0});
}

msg::BatteryState ToBatteryState(const Battery& battery, const BatterySpec& spec, Duration at) {
  constexpr double kEmptyV = 21.0, kFullV = 29.0;
  const double share = battery.percent() / 100;
  const double voltage = kEmptyV + (kFullV - kEmptyV) * share;
  const double capacity_ah = spec.capacity_wh / ((kEmptyV + kFullV) / 2);
  using State = msg::BatteryState;
  State state;
  state.header = {msg::ToStamp(at), "battery_id"};
  state.voltage = static_cast<float>(voltage);
  state.temperature = std::numeric_limits<float>::quiet_NaN();  // not measured
  state.current = static_cast<float>(battery.power_w() / voltage);
  state.charge = static_cast<float>(capacity_ah * share);
  state.capacity = static_cast<float>(capacity_ah);
  state.design_capacity = state.capacity;
  state.percentage = static_cast<float>(share);
  state.power_supply_status = !battery.charging()       ? State::kStatusDischarging
                              : battery.percent() < 100 ? State::kStatusCharging
                                                        : State::kStatusFull;
  state.power_supply_health = State::kHealthGood;
  state.power_supply_technology = State::kTechnologyLion;
  state.present = true;
  state.location = battery.cable() ? "cable" : battery.charging() ? "pad" : "";
  return state;
}

msg::ObjectStates ToObjectStates(const World& world) {
  const Scene& scene = world.scene();
  msg::ObjectStates states;
  states.header = {msg::ToStamp(world.now()), kMapFrame};
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const FleetObject& object = world.fleet().objects()[i];
    msg::ObjectState state;
    state.name = scene.objects[i].name;
    state.category = scene.objects[i].category;
    state.pose = PoseOf(object.middle_m, object.yaw_rad);
    if (object.held_by) state.held_by = scene.robots[*object.held_by].name;
    states.objects.push_back(std::move(state));
  }
  return states;
}

msg::ObjectStates ObjectsInSightOf(const World& world, std::size_t robot) {
  msg::ObjectStates all = ToObjectStates(world);
  msg::ObjectStates in_sight;
  in_sight.header = all.header;
  for (const std::size_t i : ObjectsInSight(world, robot)) {
    in_sight.objects.push_back(std::move(all.objects[i]));
  }
  return in_sight;
}

msg::ObjectStates DetectionsOf(const World& world, std::size_t robot) {
  const Scene& scene = world.scene();
  msg::ObjectStates found;
  found.header = {msg::ToStamp(world.now()), scene.robots.at(robot).name};
  for (const DetectedObject& seen : DetectObjects(world, robot)) {
    const ObjectSpec& spec = scene.objects[seen.object];
    found.objects.push_back({spec.name, spec.category, PoseOf(seen.middle_m, seen.yaw_rad), ""});
  }
  return found;
}

msg::YellowLines LinesInView(const World& world, std::size_t robot) {
  constexpr double kEveryM = 0.02;  // of a line
  const LineViewSpec& view = *world.scene().robots.at(robot).line_view;
  const RobotBody& body = world.fleet().robots()[robot].body;
  const Eigen::Rotation2Dd to_body(-body.yaw_rad());
  std::vector<Eigen::Vector2d> seen;  // in the frame of the robot
  for (const Line& line : world.scene().lines) {
    for (std::size_t i = 1; i < line.points_m.size(); ++i) {
      const Eigen::Vector2d along = line.points_m[i] - line.points_m[i - 1];
      const int steps = static_cast<int>(along.norm() / kEveryM) + 1;
      for (int step = 0; step <= steps; ++step) {
        const Eigen::Vector2d at = line.points_m[i - 1] + along * (double(step) / steps);
        const Eigen::Vector2d from_body = to_body * (at - body.position_m().head<2>());
        const double ahead_m = from_body.x() - view.ahead_m;
        const bool inside =
            ahead_m >= 0 && ahead_m <= view.depth_m && std::abs(from_body.y()) <= view.width_m / 2;
        if (inside) seen.push_back(from_body);
      }
    }
  }
  msg::YellowLines lines;
  lines.header = {msg::ToStamp(world.now()), world.scene().robots[robot].name};
  lines.ycy = lines.dy = lines.walk = "center";
  lines.middle_offset = lines.bottom_gap_px = std::numeric_limits<float>::quiet_NaN();
  if (seen.empty()) return lines;
  lines.contours = 1;
  double left_m = 0;
  for (const Eigen::Vector2d& at : seen) {
    left_m += at.y() / static_cast<double>(seen.size());
    lines.edge_x.push_back(static_cast<float>(0.5 - at.y() / view.width_m));
    lines.edge_y.push_back(static_cast<float>(1 - (at.x() - view.ahead_m) / view.depth_m));
  }
  lines.middle_offset = static_cast<float>(-left_m / view.width_m);
  return lines;
}

BodyVelocity FromMessage(const msg::Twist& twist) {
  return {{twist.linear.x, twist.linear.y, twist.linear.z}, twist.angular.z};
}

Result<HandRequest> FromMessage(const msg::ManipulationControl::Request& request) {
  using Control = msg::ManipulationControl;
  HandRequest hand;
  hand.object = request.object;
  hand.distance_threshold_m = request.distance_threshold_m;
  hand.target_m = {request.target.x, request.target.y, request.target.z};
  switch (request.action) {
    case Control::kCheckDistance:
      hand.action = HandAction::kCheckDistance;
      break;
    case Control::kAttach:
      hand.action = HandAction::kAttach;
      break;
    case Control::kRelease:
      hand.action = HandAction::kRelease;
      break;
    case Control::kPlace:
      hand.action = HandAction::kPlace;
      break;
    default:
      return Error{kCodeFailed, "unknown action " + std::to_string(request.action) +
                                    ": expected 0 (check distance), 1 (attach), 2 (release) or 3 "
                                    "(place)"};
  }
  return hand;
}

}  // namespace musher::world
