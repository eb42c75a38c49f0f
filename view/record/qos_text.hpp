#pragma once
// The QoS of a topic's writers as rosbag2 keeps it in a channel's metadata "offered_qos_profiles":
// a YAML list, one entry of each writer. `ros2 bag play` reads it, too. Pure.

#include <string>
#include <string_view>
#include <vector>

#include "musher/transport/endpoint.hpp"

namespace musher::view {

inline constexpr const char* kOfferedQos = "offered_qos_profiles";

// Discovery does not say a writer's depth: it is written as unknown.
std::string QosText(const std::vector<transport::Qos>& offered);

// The QoS with which a recorded topic is published: reliable and latched if one of the recorded
// writers was, so that every reader of the original matches. Words and the numbers of older rosbag2
// are read; what is missing or unknown is ROS 2's default.
transport::Qos QosFrom(std::string_view text);

}  // namespace musher::view
