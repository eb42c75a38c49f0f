#pragma once
// A DDS domain for each test process, so that tests which run at the same time do not meet. A
// domain that is in use is locked by a name that the kernel frees when its process ends.

#include <unistd.h>

#include <optional>
#include <string>

#include "musher/transport/host.hpp"

namespace musher::transport {

// 1 to 100, the same for the whole life of this process.
inline int TestDomain() {
  static std::optional<NameLock> lock;
  static const int domain = [] {
    for (int i = 0;; ++i) {
      const int candidate = 1 + (getpid() + i) % 100;
      auto taken = NameLock::Acquire("musher-test-domain/" + std::to_string(candidate));
      if (!taken) continue;
      lock.emplace(std::move(taken).value());
      return candidate;
    }
  }();
  return domain;
}

}  // namespace musher::transport
