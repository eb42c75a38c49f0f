#pragma once
// A second host: namespaces of its own for network and processes, a link to it, and a program on it
// that starts and restarts its actuators.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/fault_injection/host/link.hpp"

namespace musher::fault_injection {

// How long an actuator there is down.
inline constexpr int kFarRestartMs = 1000;

class FarHost {
 public:
  // Its actuators start at Go(), since they read the config in this folder.
  FarHost(const std::filesystem::path& folder, const benchmark::Child::Environment& environment);

  void Go();
  // Kills all of its processes and starts its actuators again at once, as after a reboot: with
  // another boot id and a boot clock that has just begun.
  void Reboot();
  // The command line that runs `words` on that host.
  std::vector<std::string> There(const std::vector<std::string>& words) const;
  Link& link() { return *link_; }
  pid_t pid() const { return host_.pid(); }

 private:
  const std::filesystem::path go_;
  benchmark::Child host_;
  pid_t init_ = 0;  // of its pid namespace
  std::unique_ptr<Link> link_;
};

}  // namespace musher::fault_injection
