#pragma once
// An example for the help of each command.

#include <string_view>

namespace musher::cli {

// "musher set LowPower"; empty for a command without one.
std::string_view ExampleOf(std::string_view command);

}  // namespace musher::cli
