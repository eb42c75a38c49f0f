#pragma once
// What a process costs, by /proc.

#include <sys/types.h>

#include <cstdint>

#include "musher/base/time.hpp"

namespace musher::benchmark {

struct Cost {
  double resident_mb = 0;      // RSS
  double proportional_mb = 0;  // PSS: shared pages counted by share
  int threads = 0;
  Duration cpu{};  // used since its start
  std::int64_t context_switches = 0;
};

Cost CostOf(pid_t pid);

}  // namespace musher::benchmark
