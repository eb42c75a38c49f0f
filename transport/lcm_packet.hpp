#pragma once
// LCM's messages as UDP datagrams (https://lcm-proj.github.io: "LC02"). A datagram is a magic
// number, a number that its sender counts up, the name of a channel and the encoded message. Of a
// message that needs several datagrams ("LC03", above 64 KiB) only the channel is read.
//
// Threads: any. Pure functions.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::transport {

inline constexpr std::size_t kLongestLcmChannel = 63;
inline constexpr std::size_t kLongestLcmDatagram = 65'507;  // that UDP over IPv4 carries

// Refers to the bytes of its datagram.
struct LcmPacket {
  std::uint32_t sequence = 0;  // counted by the sender over all its channels
  std::string_view channel;
  std::span<const std::byte> data;
};

// A part of a message that needs several datagrams. Refers to the bytes of its datagram.
struct LcmFragment {
  std::string_view channel;  // of the first one; empty: a later one, which has none
  std::uint32_t message_size = 0;
};

// Where the host is that has sent a datagram.
enum class HostPlace { kThisComputer, kThisNetwork, kElsewhere };

// nullopt: the bytes are no whole LCM message.
std::optional<LcmPacket> ReadLcmPacket(std::span<const std::byte> datagram);
// nullopt: they are no part of one.
std::optional<LcmFragment> ReadLcmFragment(std::span<const std::byte> datagram);

// Fails if the name of the channel or the message is too long.
Result<std::vector<std::byte>> WriteLcmPacket(const LcmPacket& packet);

// "udpm://239.255.76.67:7671", with "?ttl=1" for the number of routers that may pass it on.
struct LcmUrl {
  std::string group;  // an IPv4 multicast address
  std::uint16_t port = 0;
  std::optional<int> ttl;

  friend bool operator==(const LcmUrl&, const LcmUrl&) = default;
};
Result<LcmUrl> ReadLcmUrl(std::string_view text);
std::string ToText(const LcmUrl& url);  // without the ttl

}  // namespace musher::transport
