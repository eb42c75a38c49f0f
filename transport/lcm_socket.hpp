#pragma once
// A multicast group of LCM on the event loop: sends messages and receives those of all programs of
// the group, also its own. Other than LCM's own library it needs no thread, names the sender of a
// message and its number, and takes the network interface as an option.
//
//   auto socket = LcmSocket::Open(loop, {url, "eth0", 1}, [](const LcmSample& sample) { ... });
//   socket.value()->Send("robot_control_cmd", bytes);
//
// Threads: loop thread only. On a simulated loop, which has no sockets, nothing is received.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/lcm_packet.hpp"

namespace musher::transport {

struct LcmOptions {
  LcmUrl url;
  std::string network_interface;  // "eth0"; empty: that of the route to the group
  int ttl = 1;                    // if the url has none; 0: on this host only
};

// A datagram of the group; the callback's only.
struct LcmSample {
  std::string sender;               // "192.168.44.233:41234"
  std::optional<LcmPacket> packet;  // nullopt: no LCM message, or a part of one
  std::optional<LcmFragment> fragment;
  std::size_t size = 0;  // of the datagram, in bytes
  // The time since the kernel of this computer received the datagram: how long it waited for the
  // loop. 1 s at most.
  Duration age{};
};

class LcmSocket {
 public:
  using OnSample = std::function<void(const LcmSample&)>;

  // Fails with what to type where no route leads to the group, or its interface has no multicast.
  static Result<std::unique_ptr<LcmSocket>> Open(EventLoop& loop, const LcmOptions& options,
                                                 OnSample on_sample);

  // One datagram. Returns at once.
  Result<> Send(std::string_view channel, std::span<const std::byte> data);

  // The sender of the messages that Send() sends, as others see it.
  const std::string& sender() const { return sender_; }
  // "udpm://239.255.76.67:7670 by eth0 (192.168.44.1)".
  const std::string& name() const { return name_; }
  // The network interface by which it sends; empty: none has its address any longer.
  const std::string& network_interface() const { return network_interface_; }

 private:
  LcmSocket(LcmUrl url, OnSample on_sample)
      : url_(std::move(url)), on_sample_(std::move(on_sample)) {}

  Result<> OpenSender(const LcmOptions& options);
  Result<> OpenReceiver(const LcmOptions& options);
  void Receive();

  const LcmUrl url_;
  const OnSample on_sample_;
  std::string sender_;
  std::string name_;
  std::string network_interface_;
  std::uint32_t sequence_ = 0;
  std::vector<std::byte> buffer_;
  UniqueFd out_;
  UniqueFd in_;
  LoopHandlePtr readable_;  // last: its callback uses the rest
};

// The IPv4 addresses that this computer had when it was made. To read them takes some 50 us: more
// than a datagram of a flood may cost. A plain value.
class HostAddresses {
 public:
  HostAddresses();

  // Where the host of a sender is, "192.168.44.233:41234": whether it is in the network of an
  // address of `network_interface`; empty: of any interface.
  HostPlace PlaceOf(const std::string& sender, const std::string& network_interface) const;

 private:
  struct Address {
    std::string network_interface;
    std::uint32_t address = 0;  // in network byte order, as its mask
    std::uint32_t mask = 0;
  };
  std::vector<Address> addresses_;
};

}  // namespace musher::transport
