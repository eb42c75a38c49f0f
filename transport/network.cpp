#include "musher/transport/network.hpp"

#include <ifaddrs.h>
#include <net/if.h>
#include <sys/socket.h>

#include <memory>

namespace musher::transport {

bool HasNetwork() {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return true;  // unknown: assume yes
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(all, freeifaddrs);
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    const bool up = (one->ifa_flags & IFF_UP) != 0 && (one->ifa_flags & IFF_LOOPBACK) == 0;
    if (up && one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET) return true;
  }
  return false;
}

}  // namespace musher::transport
