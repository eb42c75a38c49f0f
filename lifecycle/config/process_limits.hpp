#pragma once
// What the process of an actuator may use, and as which user it runs.

#include <cstdint>
#include <optional>
#include <string>

namespace musher {

struct ProcessLimits {
  std::optional<std::int64_t> memory_max_bytes;  // of the process and all that it starts
  std::optional<double> cpus;                    // CPU time, in CPUs; of all of them too
  std::optional<int> nice;                       // -20 to 19
  std::optional<int> realtime_priority;          // of SCHED_FIFO, 1 to 99
  std::string user;                              // empty: that which starts it

  friend bool operator==(const ProcessLimits&, const ProcessLimits&) = default;
};

}  // namespace musher
