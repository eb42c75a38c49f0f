#pragma once
// A DDS domain for each test process, so that tests which run at the same time do not meet. A
// domain that is in use is locked by a name that the kernel frees when its process ends. One in
// which a robot runs, started by hand or left behind by a test that was killed, is passed over.

#include <unistd.h>

#include <fstream>
#include <optional>
#include <string>

#include "musher/transport/host.hpp"

namespace musher::transport {

// Whether an actuator or a controller of this host holds a name in the domain.
inline bool RobotRunsIn(int domain) {
  std::ifstream table("/proc/net/unix");
  const std::string begin = " @musher/" + std::to_string(domain) + "/";
  for (std::string line; std::getline(table, line);) {
    if (line.find(begin) != std::string::npos) return true;
  }
  return false;
}

// 1 to 100, the same for the whole life of this process.
inline int TestDomain() {
  static std::optional<NameLock> lock;
  static const int domain = [] {
    for (int i = 0;; ++i) {
      const int candidate = 1 + (getpid() + i) % 100;
      auto taken = NameLock::Acquire("musher-test-domain/" + std::to_string(candidate));
      if (!taken || RobotRunsIn(candidate)) continue;
      lock.emplace(std::move(taken).value());
      return candidate;
    }
  }();
  return domain;
}

}  // namespace musher::transport
