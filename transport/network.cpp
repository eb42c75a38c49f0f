#include "musher/transport/network.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>

#include "musher/base/unique_fd.hpp"

namespace musher::transport {

namespace {

NetworkInterface* Find(std::vector<NetworkInterface>& interfaces, std::string_view name) {
  const auto found = std::ranges::find(interfaces, name, &NetworkInterface::name);
  return found == interfaces.end() ? nullptr : &*found;
}

// IFLA_INFO_KIND of IFLA_LINKINFO.
std::string KindOf(rtattr* info) {
  int left = static_cast<int>(RTA_PAYLOAD(info));
  for (auto* part = static_cast<rtattr*>(RTA_DATA(info)); RTA_OK(part, left);
       part = RTA_NEXT(part, left)) {
    if (part->rta_type != IFLA_INFO_KIND) continue;
    const std::string kind(static_cast<const char*>(RTA_DATA(part)), RTA_PAYLOAD(part));
    return kind.substr(0, kind.find('\0'));
  }
  return "";
}

NetworkInterface ReadLink(nlmsghdr* message) {
  auto* link = static_cast<ifinfomsg*>(NLMSG_DATA(message));
  NetworkInterface read;
  read.up = (link->ifi_flags & IFF_UP) != 0;
  read.loopback = (link->ifi_flags & IFF_LOOPBACK) != 0;
  read.multicast = (link->ifi_flags & IFF_MULTICAST) != 0;
  read.ethernet = link->ifi_type == ARPHRD_ETHER;
  int left = static_cast<int>(IFLA_PAYLOAD(message));
  for (rtattr* part = IFLA_RTA(link); RTA_OK(part, left); part = RTA_NEXT(part, left)) {
    if (part->rta_type == IFLA_IFNAME) read.name = static_cast<const char*>(RTA_DATA(part));
    if (part->rta_type == IFLA_LINKINFO) read.kind = KindOf(part);
  }
  return read;
}

// Asks the kernel and not /sys, which may show the interfaces of another network namespace.
std::vector<NetworkInterface> ReadLinks() {
  std::vector<NetworkInterface> links;
  const UniqueFd kernel(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
  struct {
    nlmsghdr header;
    ifinfomsg link;
  } request{};
  request.header.nlmsg_len = NLMSG_LENGTH(sizeof request.link);
  request.header.nlmsg_type = RTM_GETLINK;
  request.header.nlmsg_flags = NLM_F_REQUEST | NLM_F_DUMP;
  if (send(kernel.get(), &request, request.header.nlmsg_len, 0) < 0) return links;
  alignas(nlmsghdr) std::array<char, 32 << 10> buffer;
  for (;;) {
    const ssize_t size = recv(kernel.get(), buffer.data(), buffer.size(), 0);
    if (size <= 0) return links;
    auto left = static_cast<unsigned int>(size);
    for (auto* message = reinterpret_cast<nlmsghdr*>(buffer.data()); NLMSG_OK(message, left);
         message = NLMSG_NEXT(message, left)) {
      if (message->nlmsg_type != RTM_NEWLINK) return links;
      links.push_back(ReadLink(message));
    }
  }
}

bool IsUsable(const NetworkInterface& one) {
  return one.up && !one.addresses.empty();
}

// A device, or what stands for several of them.
bool IsDevice(const NetworkInterface& one) {
  const bool own =
      one.kind.empty() || one.kind == "bond" || one.kind == "team" || one.kind == "vlan";
  return own && one.ethernet && !one.loopback;
}

// Whether a container or a virtual machine has the interface. A tunnel is none: its other end is a
// VPN.
bool IsOfAContainer(const NetworkInterface& one) {
  return one.ethernet && !one.loopback && one.kind != "bridge" && one.kind != "dummy";
}

std::string Obstacle(const NetworkInterface& one) {
  return !one.up ? "it is down" : "it has no IPv4 address";
}

std::vector<InterfaceUse> ChooseConfigured(std::vector<NetworkInterface> present,
                                           const std::vector<std::string>& configured) {
  std::vector<InterfaceUse> uses;
  for (const std::string& name : configured) {
    const NetworkInterface* found = Find(present, name);
    const bool used = found != nullptr && IsUsable(*found);
    uses.push_back({name, used,
                    used               ? "[transport] interfaces names it"
                    : found == nullptr ? "it does not exist"
                                       : Obstacle(*found)});
  }
  for (const NetworkInterface& one : present) {
    if (one.loopback || std::ranges::count(configured, one.name) != 0) continue;
    uses.push_back({one.name, false, "[transport] interfaces does not name it"});
  }
  return uses;
}

// Cyclone sends by the first address of each.
std::vector<std::string> UsesWithAddress(const std::vector<NetworkInterface>& present,
                                         const std::vector<std::string>& configured) {
  std::vector<std::string> texts;
  for (const InterfaceUse& use : ChooseInterfaces(present, configured)) {
    if (!use.used) continue;
    const auto found = std::ranges::find(present, use.name, &NetworkInterface::name);
    texts.push_back(use.name + " with " + found->addresses.front());
  }
  return texts;
}

}  // namespace

std::vector<std::string> MissedInterfaces(const std::vector<NetworkInterface>& before,
                                          const std::vector<NetworkInterface>& now,
                                          const std::vector<std::string>& configured) {
  const std::vector<std::string> known = UsesWithAddress(before, configured);
  std::vector<std::string> missed = UsesWithAddress(now, configured);
  std::erase_if(missed,
                [&](const std::string& use) { return std::ranges::count(known, use) != 0; });
  return missed;
}

std::vector<NetworkInterface> ReadInterfaces() {
  std::vector<NetworkInterface> interfaces = ReadLinks();
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return interfaces;
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(all, freeifaddrs);
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    // An address may have a label, "eth0:1", instead of the interface's name.
    const std::string_view label = one->ifa_name;
    NetworkInterface* known = Find(interfaces, label.substr(0, label.find(':')));
    if (known == nullptr) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
    known->addresses.emplace_back(text.data());
  }
  return interfaces;
}

std::vector<InterfaceUse> ChooseInterfaces(const std::vector<NetworkInterface>& present,
                                           const std::vector<std::string>& configured) {
  if (!configured.empty()) return ChooseConfigured(present, configured);
  const bool has_device = std::ranges::any_of(present, IsDevice);
  std::vector<InterfaceUse> uses;
  std::size_t chosen = 0;
  for (const NetworkInterface& one : present) {
    if (one.loopback) continue;
    InterfaceUse use{one.name, false, Obstacle(one)};
    const bool instead = !has_device && IsOfAContainer(one);
    if (!IsDevice(one) && !instead) {
      use.reason =
          (one.kind.empty() ? "it is no ethernet or wifi" : "it is virtual (" + one.kind + ")") +
          "; [transport] interfaces can name it";
    } else if (IsUsable(one)) {
      use.used = chosen++ < kMostOuterInterfaces;
      use.reason = !use.used ? "Cyclone uses at most 3 beside the loopback"
                   : instead ? "this host has no ethernet or wifi device"
                             : "an ethernet or wifi device that is up";
    }
    uses.push_back(std::move(use));
  }
  return uses;
}

std::vector<std::string> OuterInterfaces(TransportProfile profile,
                                         const std::vector<std::string>& configured) {
  if (profile == TransportProfile::kLocal || !configured.empty()) {
    return profile == TransportProfile::kLocal ? std::vector<std::string>() : configured;
  }
  std::vector<std::string> names;
  for (const InterfaceUse& use : ChooseInterfaces(ReadInterfaces(), {})) {
    if (use.used) names.push_back(use.name);
  }
  return names;
}

std::string InterfacesXml(const std::vector<std::string>& outer) {
  std::string xml = "<Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/>";
  for (const std::string& name : outer) {
    xml += "<NetworkInterface name=\"" + name + "\" presence_required=\"false\"/>";
  }
  return xml + "</Interfaces>";
}

}  // namespace musher::transport
