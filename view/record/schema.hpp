#pragma once
// The definition of a message type, for the files.

#include <string>
#include <string_view>

namespace musher::view {

// The text of a type of DDS in ROS 2's .msg format, with the types that it uses; "": Musher does
// not know the type.
std::string SchemaText(std::string_view dds_type);

}  // namespace musher::view
