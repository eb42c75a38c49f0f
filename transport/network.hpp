#pragma once
// The network interfaces of this host, and which of them processes of the profile lan use beside
// the loopback.
//
// Threads: any.

#include <cstddef>
#include <string>
#include <vector>

#include "musher/base/network_profile.hpp"

namespace musher::transport {

struct NetworkInterface {
  std::string name;
  bool up = false;
  bool loopback = false;
  bool multicast = false;
  std::vector<std::string> addresses;  // IPv4
  bool ethernet = true;                // also wifi
  // The kernel's kind of an interface that is not a device: "veth", "bridge", "tun", "wireguard".
  std::string kind = {};
};

// Cyclone 0.10 uses at most four, and the loopback is one.
inline constexpr std::size_t kMostOuterInterfaces = 3;

// In the order of the kernel; none if it does not answer.
std::vector<NetworkInterface> ReadInterfaces();

// Whether a process that starts now uses an interface, and why.
struct InterfaceUse {
  std::string name;
  bool used = false;
  std::string reason;
};

// The outer interfaces of the profile lan: `configured`, by the config and in its order. Without
// any: ethernet and wifi devices that are up with an IPv4 address; on a host without any such
// device (a container), virtual ethernets that are up with an address, but no bridge. Never a
// tunnel: its network is not the robot's.
//
// A pure function; each interface but the loopback, and each configured name, has an entry.
std::vector<InterfaceUse> ChooseInterfaces(const std::vector<NetworkInterface>& present,
                                           const std::vector<std::string>& configured);

// The names that Cyclone gets for the outer interfaces; none: this process reaches its host only.
std::vector<std::string> OuterInterfaces(TransportProfile profile,
                                         const std::vector<std::string>& configured);

// The interfaces that a process would use if it started now, and that a process which started with
// `before` does not use: "wlan0 with 10.0.0.7". Pure.
std::vector<std::string> MissedInterfaces(const std::vector<NetworkInterface>& before,
                                          const std::vector<NetworkInterface>& now,
                                          const std::vector<std::string>& configured);

// Cyclone's element for the loopback, over which the processes of a host reach each other in every
// profile, and for outer interfaces. A process starts without an interface that is absent.
std::string InterfacesXml(const std::vector<std::string>& outer);

}  // namespace musher::transport
