#pragma once
// A DDS domain for each test process, so that tests which run at the same time do not meet. A
// domain that is in use is locked by a name that the kernel frees when its process ends. One in
// which a robot runs, started by hand or left behind by a test that was killed, is passed over.

#include <unistd.h>

#include <fstream>
#include <string>
#include <utility>

#include "musher/base/host.hpp"

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

struct LockedDomain {
  int id = 0;
  NameLock lock;
};

// A domain without participants, the first from `begin` on. 1 to 101: the ports of 102 to 214 are
// among those that the kernel gives to any socket, so that now and then one of them is taken, and
// the examples' tests, which have no locks, have those above.
inline LockedDomain LockFreeDomain(int begin) {
  constexpr int kCount = 101;
  for (int i = begin;; ++i) {
    const int candidate = 1 + i % kCount;
    auto taken = NameLock::Acquire("musher-test-domain/" + std::to_string(candidate));
    if (taken && !RobotRunsIn(candidate)) return {candidate, std::move(taken).value()};
  }
}

// The same for the whole life of this process.
inline int TestDomain() {
  static const LockedDomain domain = LockFreeDomain(getpid());
  return domain.id;
}

}  // namespace musher::transport
