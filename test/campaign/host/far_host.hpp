#pragma once
// A second host: namespaces of its own for network and processes, a cable to it, and a program on
// it that starts its actuators, and starts them again.

#include <filesystem>
#include <memory>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/campaign/host/cable.hpp"

namespace musher::campaign {

// How long an actuator there is down.
inline constexpr int kFarRestartMs = 1000;

class FarHost {
 public:
  // Its actuators begin once Go() is said, since they read the config in this folder.
  FarHost(const std::filesystem::path& folder, const benchmark::Child::Environment& environment);

  void Go();
  Cable& cable() { return *cable_; }
  pid_t pid() const { return host_.pid(); }

 private:
  const std::filesystem::path go_;
  benchmark::Child host_;
  std::unique_ptr<Cable> cable_;
};

}  // namespace musher::campaign
