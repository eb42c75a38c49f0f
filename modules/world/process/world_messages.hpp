#pragma once
// Converts a world's values to messages and back. Input is validated.

#include <string>

#include "musher/base/result.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/modules/world/render/render.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

msg::BodyState ToBodyState(const World& world);
msg::BatteryState ToBatteryState(const World& world);

msg::JointState ToJointState(const std::array<Axis, kJoints>& joints, Duration at);

// Of a camera whose optical frame has that name.
msg::CameraInfo ToCameraInfo(const Intrinsics& intrinsics, const std::string& frame);
msg::Image ToMessage(Image image, const std::string& frame, Duration at);

// Fails when a number is not finite, or an array has another length than the board's. An empty
// array counts as zeros.
Result<BoardCommand> FromMessage(const msg::MotionCustomCommand& message);

Pose2 FromMessage(const msg::Pose& pose);

// The colour that a light shows: its own or that of its predefined effect.
Light FromMessage(const msg::LedState& led);

}  // namespace musher::world
