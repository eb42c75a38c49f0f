#pragma once
// Converts between messages and the motion manager's values. Input from the wire is not trusted:
// an invalid rotation becomes the identity.

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/sensor_msgs/imu.hpp"
#include "musher/modules/motion/motion_backend.hpp"
#include "musher/modules/motion/motion_core.hpp"

namespace musher::motion {

Eigen::Isometry3d FromWire(const msg::Pose& pose);
BodyState FromWire(const msg::BodyState& state);
msg::MotionCustomCommand ToWire(const BodyCommand& command);

ServoCommand FromWire(const msg::MotionServoCmd& command);
MotionRequest FromWire(const msg::MotionResultCmd::Request& request);
MotionArguments FromWire(const msg::MotionCustomCommand& command);
msg::MotionServoResponse ToWire(const motion_action::ServoResponse& response);

msg::MotionStatus StatusOf(const MotionRules& rules, const MotionCore& core);
msg::Odometry OdometryOf(const BodyMotion& motion);
msg::Imu ImuOf(const BodyMotion& motion);

}  // namespace musher::motion
