#include "musher/transport/lcm_socket.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>
#include <vector>

namespace musher::transport {
namespace {

// Datagrams of one turn of the loop, so that a flood leaves time for everything else.
constexpr int kMostInATurn = 64;
constexpr int kReceiveBuffer = 1 << 20;  // bytes

sockaddr_in AddressOf(const LcmUrl& url) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url.port);
  inet_pton(AF_INET, url.group.c_str(), &address.sin_addr);
  return address;
}

std::string HostText(const sockaddr_in& address) {
  char text[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &address.sin_addr, text, sizeof text);
  return text;
}

std::string SenderText(const sockaddr_in& address) {
  return HostText(address) + ":" + std::to_string(ntohs(address.sin_port));
}

// An IPv4 address of this computer.
struct OwnAddress {
  std::string network_interface;
  in_addr address{};
  in_addr mask{};
};

in_addr AddressOf(const sockaddr* address) {
  sockaddr_in its{};
  if (address != nullptr) std::memcpy(&its, address, sizeof its);
  return its.sin_addr;
}

std::vector<OwnAddress> Addresses() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return {};
  std::vector<OwnAddress> addresses;
  for (const ifaddrs* one = list; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    addresses.push_back({one->ifa_name, AddressOf(one->ifa_addr), AddressOf(one->ifa_netmask)});
  }
  freeifaddrs(list);
  return addresses;
}

// The interface that has this address; empty: none.
std::string InterfaceOf(const in_addr& address) {
  for (const OwnAddress& own : Addresses()) {
    if (own.address.s_addr == address.s_addr) return own.network_interface;
  }
  return "";
}

// The first address of this interface; zero: none.
in_addr AddressOfInterface(const std::string& name) {
  for (const OwnAddress& own : Addresses()) {
    if (own.network_interface == name) return own.address;
  }
  return {};
}

Duration WallClock() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

// The kernel's time of receipt is that of the wall clock, which may be set meanwhile.
Duration AgeOf(msghdr& message) {
  for (cmsghdr* one = CMSG_FIRSTHDR(&message); one != nullptr; one = CMSG_NXTHDR(&message, one)) {
    if (one->cmsg_level != SOL_SOCKET || one->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec at{};
    std::memcpy(&at, CMSG_DATA(one), sizeof at);
    const Duration since =
        WallClock() - std::chrono::seconds(at.tv_sec) - std::chrono::nanoseconds(at.tv_nsec);
    return std::clamp(since, Duration::zero(), Duration(std::chrono::seconds(1)));
  }
  return Duration::zero();
}

Error Failed(const std::string& what, const LcmUrl& url) {
  return {kCodeNetError, what + " " + ToText(url) + ": " + std::strerror(errno)};
}

Error NoRoute(const LcmOptions& options) {
  const bool chosen = !options.network_interface.empty();
  const std::string device = chosen ? options.network_interface : "eth0";
  return {kCodeNetError,
          "no network route leads to the multicast group " + options.url.group +
              (chosen ? " by " + device : "") + "; type: sudo ip link set " + device +
              " up multicast on && sudo ip route add " + options.url.group + "/32 dev " + device +
              (chosen ? "" : " (eth0: the interface to the board, or name it in the config)")};
}

ip_mreqn Membership(const LcmOptions& options) {
  ip_mreqn request{};
  request.imr_multiaddr = AddressOf(options.url).sin_addr;
  request.imr_ifindex = static_cast<int>(
      options.network_interface.empty() ? 0 : if_nametoindex(options.network_interface.c_str()));
  // The address that datagrams are sent from; else Linux takes an address of another interface for
  // lo.
  request.imr_address = AddressOfInterface(options.network_interface);
  return request;
}

}  // namespace

Result<std::unique_ptr<LcmSocket>> LcmSocket::Open(EventLoop& loop, const LcmOptions& options,
                                                   OnSample on_sample) {
  const std::string& name = options.network_interface;
  if (!name.empty() && if_nametoindex(name.c_str()) == 0) {
    return Error{kCodeNetError, "this computer has no network interface '" + name +
                                    "'; `ip -brief link` lists them"};
  }
  std::unique_ptr<LcmSocket> socket(new LcmSocket(options.url, std::move(on_sample)));
  if (auto opened = socket->OpenSender(options); !opened) return opened.error();
  if (auto opened = socket->OpenReceiver(options); !opened) return opened.error();
  socket->buffer_.resize(kLongestLcmDatagram);
  socket->readable_ =
      loop.WhenReadable(socket->in_.get(), [raw = socket.get()] { raw->Receive(); });
  return socket;
}

Result<> LcmSocket::OpenSender(const LcmOptions& options) {
  out_ = UniqueFd(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!out_.valid()) return Failed("cannot make a socket for", url_);
  const int ttl = url_.ttl.value_or(options.ttl);
  if (setsockopt(out_.get(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0) {
    return Failed("cannot set the ttl of", url_);
  }
  const ip_mreqn request = Membership(options);
  if (request.imr_ifindex != 0 &&
      setsockopt(out_.get(), IPPROTO_IP, IP_MULTICAST_IF, &request, sizeof request) != 0) {
    return Failed("cannot send by " + options.network_interface + " to", url_);
  }
  const sockaddr_in group = AddressOf(url_);
  if (connect(out_.get(), reinterpret_cast<const sockaddr*>(&group), sizeof group) != 0) {
    if (errno == ENETUNREACH || errno == EHOSTUNREACH) return NoRoute(options);
    return Failed("cannot reach", url_);
  }
  sockaddr_in own{};
  socklen_t size = sizeof own;
  getsockname(out_.get(), reinterpret_cast<sockaddr*>(&own), &size);
  sender_ = SenderText(own);
  const std::string& chosen = options.network_interface;
  network_interface_ = chosen.empty() ? InterfaceOf(own.sin_addr) : chosen;
  name_ = ToText(url_) + " by " + (network_interface_.empty() ? "?" : network_interface_) + " (" +
          HostText(own) + ")";
  return Ok();
}

Result<> LcmSocket::OpenReceiver(const LcmOptions& options) {
  in_ = UniqueFd(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!in_.valid()) return Failed("cannot make a socket for", url_);
  const int on = 1;  // other programs of this host are in the group, too
  setsockopt(in_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  // Less than asked for is no fault: it is what the system permits.
  setsockopt(in_.get(), SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
  // Without a time of receipt a datagram counts as received when it is handled. So do the first
  // datagrams of the first socket of a computer that requests these times: the kernel begins to
  // stamp in a work queue, an instant later.
  setsockopt(in_.get(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  const sockaddr_in group = AddressOf(url_);  // not "any", which also gets other groups' datagrams
  if (bind(in_.get(), reinterpret_cast<const sockaddr*>(&group), sizeof group) != 0) {
    return Failed("cannot receive from", url_);
  }
  const ip_mreqn request = Membership(options);
  if (setsockopt(in_.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) != 0) {
    if (errno == ENODEV) return NoRoute(options);
    return Failed("cannot join", url_);
  }
  const int off = 0;  // else also what comes by the interfaces on which other programs have joined
  setsockopt(in_.get(), IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off);
  return Ok();
}

Result<> LcmSocket::Send(std::string_view channel, std::span<const std::byte> data) {
  const auto bytes = WriteLcmPacket({sequence_, channel, data});
  if (!bytes) return bytes.error();
  ++sequence_;
  const auto& packet = bytes.value();
  // An error that an earlier datagram met is reported here, once; this one was not sent then.
  for (int i = 0; i < 2; ++i) {
    if (send(out_.get(), packet.data(), packet.size(), 0) >= 0) return Ok();
  }
  return Failed("cannot send to", url_);
}

HostAddresses::HostAddresses() {
  for (const OwnAddress& own : Addresses()) {
    addresses_.push_back({own.network_interface, own.address.s_addr, own.mask.s_addr});
  }
}

HostPlace HostAddresses::PlaceOf(const std::string& sender,
                                 const std::string& network_interface) const {
  in_addr host{};
  if (inet_pton(AF_INET, sender.substr(0, sender.rfind(':')).c_str(), &host) != 1) {
    return HostPlace::kElsewhere;
  }
  HostPlace place = HostPlace::kElsewhere;
  for (const auto& [name, address, mask] : addresses_) {
    if (address == host.s_addr) return HostPlace::kThisComputer;
    const bool by_it = network_interface.empty() || name == network_interface;
    if (by_it && mask != 0 && ((address ^ host.s_addr) & mask) == 0) {
      place = HostPlace::kThisNetwork;
    }
  }
  return place;
}

void LcmSocket::Receive() {
  for (int i = 0; i < kMostInATurn; ++i) {
    sockaddr_in from{};
    iovec bytes{buffer_.data(), buffer_.size()};
    alignas(cmsghdr) std::array<std::byte, 64> control{};
    msghdr message{};
    message.msg_name = &from;
    message.msg_namelen = sizeof from;
    message.msg_iov = &bytes;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t read = recvmsg(in_.get(), &message, 0);
    if (read < 0) return;
    LcmSample sample;
    sample.age = AgeOf(message);
    sample.sender = SenderText(from);
    sample.size = static_cast<std::size_t>(read);
    sample.packet = ReadLcmPacket(std::span(buffer_).first(sample.size));
    if (!sample.packet) sample.fragment = ReadLcmFragment(std::span(buffer_).first(sample.size));
    on_sample_(sample);
  }
}

}  // namespace musher::transport
