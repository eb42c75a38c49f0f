#pragma once
// Multicast groups of LCM for each test process, so that tests which run at the same time do not
// meet. Their ports differ too: a program of LCM's own library receives whatever is sent to its
// port, of every group that a program of this host has joined. The ports are in the range of the
// process's DDS domain, which is locked, above those of its first 50 participants.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <string>
#include <string_view>

#include "musher/base/unique_fd.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/transport/lcm_packet.hpp"

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

// Sends bytes as they are to a group of the loopback; from another one of its addresses as another
// host would.
class RawLcmSender {
 public:
  explicit RawLcmSender(const std::string& url, const char* from = "127.0.0.1")
      : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)), group_(Address("", 0)) {
    const LcmUrl parsed = ReadLcmUrl(url).value();
    group_ = Address(parsed.group.c_str(), parsed.port);
    const in_addr loopback{htonl(INADDR_LOOPBACK)};
    setsockopt(socket_.get(), IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof loopback);
    const sockaddr_in own = Address(from, 0);
    bound_ = bind(socket_.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0;
  }

  bool Send(std::string_view bytes) const {
    const auto sent = sendto(socket_.get(), bytes.data(), bytes.size(), 0,
                             reinterpret_cast<const sockaddr*>(&group_), sizeof group_);
    return bound_ && sent == static_cast<ssize_t>(bytes.size());
  }

 private:
  static sockaddr_in Address(const char* address, std::uint16_t port) {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_port = htons(port);
    inet_pton(AF_INET, address, &result.sin_addr);
    return result;
  }

  UniqueFd socket_;
  sockaddr_in group_;
  bool bound_ = false;
};

}  // namespace musher::transport
