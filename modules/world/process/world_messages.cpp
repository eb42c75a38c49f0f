#include "musher/modules/world/process/world_messages.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/base/words.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/yaw.hpp"
#include "musher/modules/world/process/robot_messages.hpp"

namespace musher::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

msg::Vector3 ToVector(const Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Result<Vector3d> ToVector(const std::vector<float>& values, const char* name) {
  if (values.empty()) return Vector3d(0, 0, 0);
  if (values.size() != 3) {
    return Error{kCodeFailed,
                 std::string(name) + " has " + Counted(values.size(), "value") + ", expected 3"};
  }
  const Vector3d vector(values[0], values[1], values[2]);
  if (!vector.allFinite()) return Error{kCodeFailed, std::string(name) + " is not a number"};
  return vector;
}

}  // namespace

msg::BodyState ToBodyState(const World& world) {
  const Body& body = world.body();
  msg::BodyState state;
  state.header = {msg::ToStamp(world.now()), "odom"};
  state.mode = static_cast<std::int8_t>(body.mode());
  state.gait_id = static_cast<std::int8_t>(body.gait());
  constexpr std::int8_t kAllFeet = 15;
  const bool off_the_ground = body.in_the_air() || body.status() == BoardStatus::kLifted;
  state.contact = off_the_ground ? std::int8_t{0} : kAllFeet;
  state.order_process_bar = static_cast<std::int8_t>(body.progress_percent());
  state.switch_status = static_cast<std::int8_t>(body.status());
  state.ori_error = body.status() == BoardStatus::kOrientation ? 1 : 0;
  state.footpos_error = body.status() == BoardStatus::kFoot ? 1 : 0;
  state.motor_error = body.motor_errors();
  for (std::size_t i = 0; i < kMotors; ++i) {
    state.motor_temperature.at(i) = static_cast<float>(body.motor_temperature_c(i));
  }
  state.life_count = body.life_count();
  const Pose2& odometry = body.odometry();
  const Attitude& attitude = body.attitude();
  state.pose.position = {odometry.position_m.x(), odometry.position_m.y(), attitude.height_m};
  const Quaterniond turned = AngleAxisd(odometry.yaw_rad, Vector3d::UnitZ()) *
                             AngleAxisd(attitude.pitch_rad, Vector3d::UnitY()) *
                             AngleAxisd(attitude.roll_rad, Vector3d::UnitX());
  state.pose.orientation = {turned.x(), turned.y(), turned.z(), turned.w()};
  state.twist = {ToVector(body.speed()), ToVector(body.turn_rate())};
  state.linear_acceleration = ToVector(body.acceleration());
  return state;
}

msg::BatteryState ToBatteryState(const World& world) {
  return ToBatteryState(world.battery(), world.scene().battery, world.now());
}

msg::JointState ToJointState(const std::array<Axis, kJoints>& joints, Duration at) {
  msg::JointState message;
  message.header.stamp = msg::ToStamp(at);
  for (std::size_t i = 0; i < kJoints; ++i) {
    message.name.emplace_back(JointTable()[i].name);
    message.position.push_back(joints[i].position_rad);
    message.velocity.push_back(joints[i].speed_rad_s);
  }
  return message;
}

msg::CameraInfo ToCameraInfo(const Intrinsics& intrinsics, const std::string& frame) {
  msg::CameraInfo info;
  info.header.frame_id = frame;
  info.width = static_cast<std::uint32_t>(intrinsics.width_px);
  info.height = static_cast<std::uint32_t>(intrinsics.height_px);
  const bool pinhole = intrinsics.model == CameraModel::kPinhole;
  info.distortion_model = pinhole ? msg::CameraInfo::kPlumbBob : msg::CameraInfo::kEquidistant;
  info.d.assign(pinhole ? 5 : 4, 0);
  const double f = intrinsics.focal_px;
  const double x = intrinsics.center_px.x();
  const double y = intrinsics.center_px.y();
  info.k = {f, 0, x, 0, f, y, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {f, 0, x, 0, 0, f, y, 0, 0, 0, 1, 0};
  return info;
}

msg::Image ToMessage(Image image, const std::string& frame, Duration at) {
  msg::Image message;
  message.header = {msg::ToStamp(at), frame};
  message.width = static_cast<std::uint32_t>(image.width);
  message.height = static_cast<std::uint32_t>(image.height);
  message.encoding = "bgr8";
  message.step = 3 * message.width;
  message.data = std::move(image.bgr);
  return message;
}

Result<BoardCommand> FromMessage(const msg::MotionCustomCommand& message) {
  const Result<Vector3d> speed = ToVector(message.vel_des, "vel_des");
  const Result<Vector3d> attitude = ToVector(message.rpy_des, "rpy_des");
  const Result<Vector3d> position = ToVector(message.pos_des, "pos_des");
  for (const auto* vector : {&speed, &attitude, &position}) {
    if (!*vector) return vector->error();
  }
  if (message.duration < 0) return Error{kCodeFailed, "duration is negative"};
  constexpr double kMostTiltRad = 0.8;
  constexpr double kMostRaisedM = 0.15;
  BoardCommand command;
  // NOLINTBEGIN(bugprone-signed-char-misuse): they are numbers, not characters
  command.mode = message.mode;
  command.gait = message.gait_id;
  // NOLINTEND(bugprone-signed-char-misuse)
  command.life_count = message.life_count;
  command.speed = speed.value();
  command.attitude = attitude.value().cwiseMax(-kMostTiltRad).cwiseMin(kMostTiltRad);
  command.raised_m = std::clamp(position.value().z(), -kMostRaisedM, kMostRaisedM);
  command.duration = Milliseconds(message.duration);
  return command;
}

Pose2 FromMessage(const msg::Pose& pose) {
  return {{pose.position.x, pose.position.y}, msg::YawOf(pose.orientation)};
}

Light FromMessage(const msg::LedState& led) {
  constexpr std::uint8_t kPredefined = 1;
  if (led.mode != kPredefined) return {led.r, led.g, led.b};
  if (led.effect >= 0xA1 && led.effect <= 0xA7) return {255, 0, 0};
  if (led.effect >= 0xA8 && led.effect <= 0xAE) return {0, 0, 255};
  if (led.effect >= 0xAF && led.effect <= 0xB5) return {255, 220, 0};
  return {};  // off
}

}  // namespace musher::world
