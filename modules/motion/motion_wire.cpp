#include "musher/modules/motion/motion_wire.hpp"
#include "musher/messages/stamp.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace musher::motion {
namespace {

constexpr const char* kBodyFrame = "base_link_leg";
constexpr const char* kImuFrame = "imu_link";

Eigen::Vector3d FromWire(const msg::Vector3& vector) {
  return {vector.x, vector.y, vector.z};
}
msg::Vector3 ToWire(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

msg::Quaternion Turn(const Eigen::Isometry3d& transform) {
  const Eigen::Quaterniond q(transform.rotation());
  return {q.x(), q.y(), q.z(), q.w()};
}

template <class Message>
MotionArguments ArgumentsOf(const Message& message) {
  MotionArguments arguments;
  arguments.vel_des = message.vel_des;
  arguments.rpy_des = message.rpy_des;
  arguments.pos_des = message.pos_des;
  arguments.acc_des = message.acc_des;
  arguments.ctrl_point = message.ctrl_point;
  arguments.foot_pose = message.foot_pose;
  arguments.step_height = message.step_height;
  arguments.value = message.value;
  return arguments;
}

msg::TransformStamped Transform(const std::string& parent, const std::string& frame,
                                const Eigen::Isometry3d& placement, Duration stamp) {
  msg::TransformStamped transform;
  transform.header = {msg::ToStamp(stamp), parent};
  transform.child_frame_id = frame;
  transform.transform = {ToWire(Eigen::Vector3d(placement.translation())), Turn(placement)};
  return transform;
}

// The name of a frame of this robot: with the prefix of `base`, such as "dog1/" of
// "dog1/base_link".
std::string FrameOf(const TfConfig& config, const std::string& name) {
  return config.base.substr(0, config.base.rfind('/') + 1) + name;
}

Eigen::Isometry3d PlacementOf(const Mount& mount) {
  const auto [roll, pitch, yaw] = mount.rpy_rad;
  Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
  placement.translate(Eigen::Vector3d(mount.xyz_m[0], mount.xyz_m[1], mount.xyz_m[2]));
  placement.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()));
  return placement;
}

// Of x, y, z, roll, pitch and yaw.
std::array<double, 36> Covariance(const std::array<double, 6>& deviations) {
  std::array<double, 36> covariance{};
  for (std::size_t i = 0; i < deviations.size(); ++i) {
    covariance.at(i * (deviations.size() + 1)) = deviations.at(i) * deviations.at(i);
  }
  return covariance;
}

template <std::size_t N>
std::vector<float> List(const std::array<float, N>& values) {
  return {values.begin(), values.end()};
}

}  // namespace

Eigen::Isometry3d FromWire(const msg::Pose& pose) {
  const msg::Quaternion& q = pose.orientation;
  Eigen::Quaterniond turn(q.w, q.x, q.y, q.z);
  const double norm = turn.norm();
  constexpr double kLeastNorm = 1e-6;
  if (!std::isfinite(norm) || norm < kLeastNorm) turn = Eigen::Quaterniond::Identity();
  Eigen::Isometry3d transform(turn.normalized());
  transform.translation() << pose.position.x, pose.position.y, pose.position.z;
  return transform;
}

bool IsFinite(const msg::BodyState& state) {
  const auto is_finite = [](const msg::Vector3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  };
  const auto& [x, y, z] = state.pose.position;
  const msg::Quaternion& q = state.pose.orientation;
  return is_finite({x, y, z}) && is_finite({q.x, q.y, q.z}) && std::isfinite(q.w) &&
         is_finite(state.twist.linear) && is_finite(state.twist.angular) &&
         is_finite(state.linear_acceleration) &&
         std::ranges::all_of(state.motor_temperature, [](float t) { return std::isfinite(t); });
}

BodyState FromWire(const msg::BodyState& state) {
  BodyState body;
  body.report = {state.mode,
                 state.gait_id,
                 state.contact,
                 state.order_process_bar,
                 state.switch_status,
                 state.ori_error,
                 state.footpos_error,
                 state.motor_error,
                 state.motor_temperature,
                 state.life_count};
  body.motion.stamp = msg::FromStamp(state.header.stamp);
  body.motion.X_OB = FromWire(state.pose);
  body.motion.v_B = FromWire(state.twist.linear);
  body.motion.w_B = FromWire(state.twist.angular);
  body.motion.a_B = FromWire(state.linear_acceleration);
  return body;
}

msg::MotionCustomCommand ToWire(const BodyCommand& command) {
  msg::MotionCustomCommand wire;
  wire.mode = command.mode;
  wire.gait_id = command.gait;
  wire.contact = command.contact;
  wire.life_count = command.life_count;
  wire.vel_des = List(command.vel);
  wire.rpy_des = List(command.rpy);
  wire.pos_des = List(command.pos);
  wire.acc_des = List(command.acc);
  wire.ctrl_point = List(command.ctrl_point);
  wire.foot_pose = List(command.foot_pose);
  wire.step_height = List(command.step_height);
  wire.value = command.value;
  wire.duration = command.duration_ms;
  return wire;
}

ServoCommand FromWire(const msg::MotionServoCmd& command) {
  return {command.cmd_type, command.cmd_source, {command.motion_id, ArgumentsOf(command)}};
}

MotionRequest FromWire(const msg::MotionResultCmd::Request& request) {
  MotionRequest requested{request.motion_id, ArgumentsOf(request)};
  requested.arguments.contact = request.contact;
  requested.arguments.duration_ms = request.duration;
  return requested;
}

MotionArguments FromWire(const msg::MotionCustomCommand& command) {
  MotionArguments arguments = ArgumentsOf(command);
  arguments.contact = std::int32_t{command.contact};  // signed on the wire; checked later
  arguments.duration_ms = command.duration;
  return arguments;
}

msg::MotionServoResponse ToWire(const motion_action::ServoResponse& response) {
  return {response.motion_id, response.cmd_id, response.bar,
          response.status,    response.result, response.code};
}

msg::MotionStatus StatusOf(const MotionRules& rules, const MotionCore& core) {
  msg::MotionStatus status;
  status.motion_id = PresentMotion(rules, core);
  if (!core.body) return status;
  const BodyReport& body = *core.body;
  status.contact = body.contact;
  status.order_process_bar = body.bar;
  status.switch_status = body.switch_status;
  status.ori_error = body.ori_error;
  status.footpos_error = body.footpos_error;
  status.motor_error.assign(body.motor_error.begin(), body.motor_error.end());
  return status;
}

msg::Odometry OdometryOf(const TfConfig& config, const BodyMotion& motion, double way_m) {
  msg::Odometry odometry;
  odometry.header = {msg::ToStamp(motion.stamp), config.odom};
  odometry.child_frame_id = FrameOf(config, kBodyFrame);
  const Eigen::Vector3d& at = motion.X_OB.translation();
  odometry.pose.pose = {{at.x(), at.y(), at.z()}, Turn(motion.X_OB)};
  odometry.twist.twist = {ToWire(motion.v_B), ToWire(motion.w_B)};
  const double drift_m = kDriftPerMetre * way_m;
  odometry.pose.covariance = Covariance(
      {drift_m, drift_m, kHeightErrorM, kTiltErrorRad, kTiltErrorRad, kYawDriftPerMetre * way_m});
  odometry.twist.covariance = Covariance({kSpeedErrorMS, kSpeedErrorMS, kSpeedErrorMS,
                                          kTurnErrorRadS, kTurnErrorRadS, kTurnErrorRadS});
  return odometry;
}

msg::Imu ImuOf(const TfConfig& config, const BodyMotion& motion) {
  msg::Imu imu;
  imu.header = {msg::ToStamp(motion.stamp), FrameOf(config, kImuFrame)};
  imu.orientation = Turn(motion.X_OB);
  imu.angular_velocity = ToWire(motion.w_B);
  imu.linear_acceleration = ToWire(motion.a_B);
  if (!motion.has_acceleration) imu.linear_acceleration_covariance[0] = -1;  // no such reading
  return imu;
}

msg::TransformStamped BodyFrame(const TfConfig& config, const BodyMotion& motion) {
  return Transform(config.odom, config.base, motion.X_OB, motion.stamp);
}

std::vector<msg::TransformStamped> FixedFrames(const TfConfig& config) {
  std::vector<msg::TransformStamped> fixed;
  const auto is_mounted = [&config](const std::string& frame) {
    return frame == config.base || std::ranges::count(config.mounts, frame, &Mount::frame) > 0;
  };
  for (const char* name : {kBodyFrame, kImuFrame}) {
    const std::string frame = FrameOf(config, name);
    if (!config.publish || is_mounted(frame)) continue;
    fixed.push_back(Transform(config.base, frame, Eigen::Isometry3d::Identity(), {}));
  }
  for (const Mount& mount : config.mounts) {
    fixed.push_back(Transform(mount.parent, mount.frame, PlacementOf(mount), {}));
  }
  return fixed;
}

}  // namespace musher::motion
