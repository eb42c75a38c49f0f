#pragma once
// What the process of an actuator may use, write and open, and as which user it runs.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace musher {

// What the process, with all that it starts, may do to the files of its host.
enum class Sandbox : std::uint8_t {
  kNone,
  kReadOnly,  // writes none, but in /dev, /proc, /sys and /tmp; gains no privileges
  kStrict,    // also sees no home folders, a /tmp of its own, and writes no settings of the kernel
};
inline constexpr std::pair<std::string_view, Sandbox> kSandboxNames[] = {
    {"none", Sandbox::kNone}, {"read-only", Sandbox::kReadOnly}, {"strict", Sandbox::kStrict}};

struct ProcessLimits {
  std::optional<std::int64_t> memory_max_bytes;  // of the process and all that it starts
  std::optional<double> cpus;                    // CPU time, in CPUs; of all of them too
  std::optional<int> nice;                       // -20 to 19
  std::optional<int> realtime_priority;          // of SCHED_FIFO, 1 to 99
  std::string user;                              // empty: that which starts it
  Sandbox sandbox = Sandbox::kNone;
  // The devices that it may open beside /dev/null and its kind; nullopt: no list. See
  // LimitsDevices().
  std::optional<std::vector<std::string>> devices = {};

  // Whether it may open the listed devices only.
  bool LimitsDevices() const { return devices || sandbox == Sandbox::kStrict; }

  friend bool operator==(const ProcessLimits&, const ProcessLimits&) = default;
};

}  // namespace musher
