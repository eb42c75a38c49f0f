#pragma once
// Between messages and what the motion manager thinks in. What comes from the wire is not trusted:
// a turn that is none becomes no turn.

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
MotionOrder FromWire(const msg::MotionResultCmd::Request& request);
MotionArguments FromWire(const msg::MotionCustomCommand& command);
msg::MotionServoResponse ToWire(const motion_action::TellServo& tell);

msg::MotionStatus StatusOf(const MotionRules& rules, const MotionCore& core);
msg::Odometry OdometryOf(const BodyMotion& motion);
msg::Imu ImuOf(const BodyMotion& motion);

}  // namespace musher::motion
