#pragma once
// Whether this user may give the processes of a config the priorities that it wants for them: for
// `musher check`. Those of another host have them from its systemd.
//
// Pure; threads: any.

#include <cstdint>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

// What this user may give.
struct Priorities {
  bool any = false;                     // CAP_SYS_NICE
  std::uint64_t highest_real_time = 0;  // RLIMIT_RTPRIO
  int lowest_nice = 0;                  // RLIMIT_NICE, or that of this process
};

std::vector<Diagnostic> CheckLimits(const MachineConfig& config, const Priorities& user);

}  // namespace musher::cli
