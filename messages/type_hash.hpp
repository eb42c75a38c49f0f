#pragma once
// The type hashes (RIHS01, REP 2011) by which ROS 2 compares the definitions of a type. Computed
// from the IDL when Musher is built (messages/generator), equal to those that rosidl computes.
//
// Threads: any; the table is constant.

#include <array>
#include <span>
#include <string_view>

namespace musher::msg {

struct TypeHash {
  std::string_view type;  // its name on DDS: "std_msgs::msg::dds_::String_"
  std::string_view hash;  // "RIHS01_" and 64 hexadecimal digits
};

// Hashes of every type in the IDL, sorted by type. A service has none of its own on the wire: its
// request and its response are types.
std::span<const TypeHash> TypeHashes();

// The hash of a type by its name on DDS; "" for a type that the IDL does not define.
std::string_view TypeHashOf(std::string_view type);

}  // namespace musher::msg
