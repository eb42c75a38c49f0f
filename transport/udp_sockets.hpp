#pragma once
// The UDP sockets of this host, by which a process finds out which addresses the other processes of
// its DDS domain send from.
//
// Threads: any.

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace musher::transport {

struct UdpSocket {
  std::string address;  // IPv4 that it is bound to; "0.0.0.0": any
  std::uint16_t port = 0;
  bool connected = false;
};

// The UDP sockets of a process; with pid 0, of all processes of a user that are not visible.
struct UdpProcess {
  pid_t pid = 0;
  uid_t user = 0;
  std::vector<UdpSocket> sockets;
};

// The processes of this network namespace with a UDP socket that is bound to another address than
// `own`, the loopback and "any". Each has all of its sockets. Where there are none, only one file
// is read.
std::vector<UdpProcess> ReadProcessesBoundElsewhere(const std::vector<std::string>& own);

// The IPv4 addresses that UDP sockets of a process are bound to: DDS sends from these addresses.
// nullopt: not known (a process of another user).
std::optional<std::vector<std::string>> BoundAddresses(pid_t pid);

// Whether two processes of this network namespace have UDP sockets that are bound to the same port,
// as all processes of a DDS domain have for multicast. False also if one of them is not visible.
bool ShareUdpPort(pid_t one, pid_t other);

// The first process of the DDS domain that sends from addresses of this host, of which none is in
// `own`. Cyclone takes such a process for a process of another host, and does not use the loopback
// towards it. The reason: an address has changed, or the config of the process names other
// interfaces. A pure function.
struct OtherAddress {
  pid_t pid = 0;  // 0: not visible
  std::string address;
};
std::optional<OtherAddress> FindOtherAddress(const std::vector<UdpProcess>& processes,
                                             int domain_id, const std::vector<std::string>& own);

}  // namespace musher::transport
