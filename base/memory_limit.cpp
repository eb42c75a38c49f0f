#include "musher/base/memory_limit.hpp"

#include <algorithm>
#include <charconv>
#include <sstream>
#include <string>
#include <string_view>

#include "musher/base/files.hpp"

namespace musher {
namespace {

// The number that the text begins with; "max" has none.
std::optional<std::uint64_t> NumberIn(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  return number;
}

// Where a hierarchy of groups is mounted, and the file in each group that has its limit.
struct Hierarchy {
  const char* mount;
  const char* file;
};

constexpr Hierarchy kFirstVersion{"sys/fs/cgroup/memory", "memory.limit_in_bytes"};
constexpr Hierarchy kSecondVersion{"sys/fs/cgroup", "memory.max"};

// `group`: "/a/b", as /proc/self/cgroup has it. In a container its groups may be mounted as the
// root, or not be visible: then the root counts.
std::optional<std::uint64_t> LeastLimit(const std::filesystem::path& root,
                                        const Hierarchy& hierarchy, const std::string& group) {
  std::optional<std::uint64_t> least;
  std::filesystem::path below = std::filesystem::path(group).relative_path();
  while (true) {
    const auto limit = NumberIn(ReadFile(root / hierarchy.mount / below / hierarchy.file));
    if (limit && (!least || *limit < *least)) least = limit;
    if (below.empty()) return least;
    below = below.parent_path();
  }
}

}  // namespace

std::optional<std::uint64_t> MemoryLimitOfGroups(const std::filesystem::path& root) {
  std::optional<std::uint64_t> least;
  std::istringstream lines(ReadFile(root / "proc/self/cgroup"));
  for (std::string line; std::getline(lines, line);) {  // "4:memory:/a/b", "0::/a/b"
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool of_all = controllers == ",,";
    if (!of_all && controllers.find(",memory,") == std::string::npos) continue;
    const auto limit =
        LeastLimit(root, of_all ? kSecondVersion : kFirstVersion, line.substr(second + 1));
    if (limit && (!least || *limit < *least)) least = limit;
  }
  return least;
}

std::optional<std::uint64_t> AvailableMemory(const std::filesystem::path& root) {
  constexpr std::string_view kKey = "MemAvailable:";
  constexpr std::uint64_t kKibibyte = 1024;
  const std::string text = ReadFile(root / "proc/meminfo");
  const std::size_t at = text.find(kKey);
  if (at == std::string::npos) return std::nullopt;
  const auto number = NumberIn(std::string_view(text).substr(at + kKey.size()));
  if (!number) return std::nullopt;
  return *number * kKibibyte;
}

}  // namespace musher
