#pragma once
// The type hashes of ROS 2's own packages, as rosidl computes them (type_hashes_jazzy.tsv).

#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "musher/test/support/paths.hpp"

namespace musher::msg {

using HashTable = std::map<std::string, std::string>;  // by "std_msgs/msg/String"

inline HashTable JazzyTypeHashes() {
  std::ifstream file(SourceDir() + "/test/contract/type_hashes_jazzy.tsv");
  HashTable table;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string type, hash;
    if (line.starts_with('#') || !(words >> type >> hash)) continue;
    table[type] = hash;
  }
  return table;
}

// "std_msgs::msg::dds_::String_" as "std_msgs/msg/String".
inline std::string RosTypeName(std::string name) {
  const std::size_t dds = name.find("::dds_::");
  if (dds == std::string::npos) return name;
  name.replace(dds, 8, "/");
  name.replace(name.find("::"), 2, "/");
  name.pop_back();
  return name;
}

}  // namespace musher::msg
