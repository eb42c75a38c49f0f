#pragma once
// Semantic versions (semver.org): 1.10.0 is newer than 1.9.3, 1.0.0-rc.2 older than 1.0.0.

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace musher::ota {

struct Version {
  std::uint64_t major = 0;
  std::uint64_t minor = 0;
  std::uint64_t patch = 0;
  std::vector<std::string> pre_release;  // "rc", "2" of 1.0.0-rc.2
  std::string text;                      // as written, including the part after '+'
};

// Orders by age; ignores the part after '+'.
std::strong_ordering Compare(const Version& a, const Version& b);

// nullopt: not MAJOR.MINOR.PATCH[-PRE][+BUILD].
std::optional<Version> ParseVersion(std::string_view text);

}  // namespace musher::ota
