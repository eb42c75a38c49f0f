#pragma once
// The version of Musher that this program was built from.

#include <string_view>

namespace musher {

// "MAJOR.MINOR.PATCH", as the build's project() says it. Every program prints it for --version.
std::string_view Version();

}  // namespace musher
