#pragma once
// Converts between messages and the motion manager's values. Input from the wire is not trusted:
// an invalid rotation becomes the identity.

#include <vector>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/sensor_msgs/imu.hpp"
#include "musher/modules/motion/motion_backend.hpp"
#include "musher/modules/motion/motion_config.hpp"
#include "musher/modules/motion/motion_core.hpp"

namespace musher::motion {

Eigen::Isometry3d FromWire(const msg::Pose& pose);
// Whether no number of it is NaN or infinite.
bool IsFinite(const msg::BodyState& state);
BodyState FromWire(const msg::BodyState& state);
msg::MotionCustomCommand ToWire(const BodyCommand& command);

ServoCommand FromWire(const msg::MotionServoCmd& command);
MotionRequest FromWire(const msg::MotionResultCmd::Request& request);
MotionArguments FromWire(const msg::MotionCustomCommand& command);
msg::MotionServoResponse ToWire(const motion_action::ServoResponse& response);

msg::MotionStatus StatusOf(const MotionRules& rules, const MotionCore& core);
// Standard deviations of the odometry of legs. No motion board reports them: these are assumed, for
// a floor that is not slippery.
inline constexpr double kDriftPerMetre = 0.05;     // m, of the position
inline constexpr double kYawDriftPerMetre = 0.02;  // rad
inline constexpr double kHeightErrorM = 0.02;      // which the legs measure
inline constexpr double kTiltErrorRad = 0.02;      // which the IMU measures
inline constexpr double kSpeedErrorMS = 0.05;
inline constexpr double kTurnErrorRadS = 0.05;

// Their frames have the names that `config` gives to those of this robot.
// `way_m`: that the body has walked since its odometry began, which its drift grows with.
msg::Odometry OdometryOf(const TfConfig& config, const BodyMotion& motion, double way_m);
msg::Imu ImuOf(const TfConfig& config, const BodyMotion& motion);

// For /tf: where the body is in the frame of its odometry, at the time of the odometry.
msg::TransformStamped BodyFrame(const TfConfig& config, const BodyMotion& motion);
// For /tf_static: the frame of `odom_out` and `imu` on the body, if the body is published, and the
// mounts. The IMU is in the body's frame: its place is that of a mount, where there is one.
std::vector<msg::TransformStamped> FixedFrames(const TfConfig& config);

}  // namespace musher::motion
