#pragma once
// The two names of a message type: ROS 2's "std_msgs/msg/String", which files have, and DDS's
// "std_msgs::msg::dds_::String_". Pure.

#include <string>
#include <string_view>

namespace musher::view {

// "" if the name is none of that kind.
std::string RosType(std::string_view dds_type);
std::string DdsType(std::string_view ros_type);

}  // namespace musher::view
