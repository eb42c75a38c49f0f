#pragma once
// A DDS domain for each test process, so that tests which run at the same time do not meet.

#include <unistd.h>

namespace musher::transport {

inline int TestDomain() {
  return 1 + getpid() % 100;
}

}  // namespace musher::transport
