#pragma once
// The definition of every type in the IDL as ROS 2's tools read it: the text that MCAP files and
// Foxglove call schema encoding "ros2msg". Made when Musher is built (messages/generator).
//
// Threads: any; the table is constant.

#include <cstddef>
#include <span>
#include <string_view>

namespace musher::msg {

struct MessageDefinition {
  std::string_view dds_type;  // "std_msgs::msg::dds_::String_"
  std::string_view ros_type;  // "std_msgs/msg/String", "std_srvs/srv/Trigger_Request"
  // Its fields, one a line, "string data"; then those of each type that it consists of, below a
  // line of 80 '=' and a line "MSG: std_msgs/Header".
  std::string_view text;
  // On the wire a client's id (uint64) and a sequence number (int64) come first: the request or
  // response of a service. The text does not have them.
  bool envelope = false;
  std::size_t appended = 0;  // so many of its last fields an older peer does not send
};

// Definitions of every type in the IDL, sorted by dds_type.
std::span<const MessageDefinition> Definitions();

// The definition with this name on DDS; null for a type that the IDL does not define.
const MessageDefinition* FindDefinition(std::string_view dds_type);

}  // namespace musher::msg
