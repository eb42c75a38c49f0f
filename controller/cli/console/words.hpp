#pragma once
// Lists and counts for sentences.

#include <cstddef>
#include <string>
#include <vector>

namespace musher::cli {

// "legs, arm"
std::string Join(const std::vector<std::string>& words);
// "1 actuator", "7 actuators"
std::string Count(std::size_t count, const char* what);

}  // namespace musher::cli
