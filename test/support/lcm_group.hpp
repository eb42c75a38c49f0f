#pragma once
// Multicast groups of LCM for each test process, so that tests which run at the same time do not
// meet. Their ports differ too: a program of LCM's own library receives whatever is sent to its
// port, of every group that a program of this host has joined. The ports are in the range of the
// process's DDS domain, which is locked, above those of its first 50 participants.

#include <string>

#include "musher/test/support/domain.hpp"

namespace musher::transport {

// Of the process that has locked this domain; `number`: 0 to 99.
inline int LcmPort(int domain, int number) {
  constexpr int kFirstDdsPort = 7400;
  constexpr int kPortsOfDomain = 250;
  constexpr int kPortsOfDds = 112;
  return kFirstDdsPort + kPortsOfDomain * domain + kPortsOfDds + number;
}
inline std::string LcmGroup(int domain) {
  return "239.254.76." + std::to_string(domain);
}

// Another one with each call.
inline std::string NextTestLcmUrl() {
  static int number = 0;
  const int domain = TestDomain();
  return "udpm://" + LcmGroup(domain) + ":" + std::to_string(LcmPort(domain, number++));
}

}  // namespace musher::transport
