#pragma once
// The definitions of types as ROS 2 describes them (REP 2016): what the service
// `<node>/get_type_description` answers, by which a tool reads samples of a type that it does not
// have. Of every type in Musher's IDL.
//
// Threads: any; the tables are constant.

#include <optional>
#include <string_view>

#include "musher/messages/type_description_interfaces/get_type_description.hpp"

namespace musher::transport {

// The description of a type by its name in ROS 2, "std_msgs/msg/String"; none for a type that the
// IDL does not have.
std::optional<msg::TypeDescription> DescribeType(std::string_view ros_type);

// The answer to a request. It fails for a type that the IDL does not have, and for another hash.
msg::GetTypeDescription::Response Describe(const msg::GetTypeDescription::Request& request);

}  // namespace musher::transport
