#pragma once
// A TCP port for a server of a benchmark.

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>

#include "musher/base/check.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher::benchmark {

// One that was free a moment ago.
inline std::uint16_t FreePort() {
  const UniqueFd fd(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  MUSHER_CHECK(bind(fd.get(), reinterpret_cast<sockaddr*>(&address), size) == 0);
  MUSHER_CHECK(getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &size) == 0);
  return ntohs(address.sin_port);
}

}  // namespace musher::benchmark
