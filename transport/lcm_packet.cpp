#include "musher/transport/lcm_packet.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <charconv>
#include <cstring>

namespace musher::transport {
namespace {

constexpr std::uint32_t kMagic = 0x4C433032;          // "LC02"
constexpr std::size_t kHeader = 8;                    // magic and sequence number
constexpr std::uint32_t kFragmentMagic = 0x4C433033;  // "LC03"
// Magic, sequence number, size of the message, offset, number of the fragment, their count.
constexpr std::size_t kFragmentHeader = 20;
constexpr std::size_t kFragmentSizeAt = 8;
constexpr std::size_t kFragmentNumberAt = 16;

std::uint32_t ReadBigEndian(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (const std::byte byte : bytes.first(4)) {
    value = value << 8 | std::to_integer<std::uint32_t>(byte);
  }
  return value;
}

void WriteBigEndian(std::uint32_t value, std::vector<std::byte>& bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::byte>(value >> shift & 0xFF));
  }
}

// The name up to its end; nullopt: it is none.
std::optional<std::string_view> ReadChannel(std::span<const std::byte> bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), std::byte{0});
  const auto length = static_cast<std::size_t>(end - bytes.begin());
  if (end == bytes.end() || length == 0 || length > kLongestLcmChannel) return std::nullopt;
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), length);
}

template <typename T>
std::optional<T> NumberOf(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool IsMulticast(const std::string& address) {
  in_addr parsed{};
  return inet_pton(AF_INET, address.c_str(), &parsed) == 1 && IN_MULTICAST(ntohl(parsed.s_addr));
}

}  // namespace

std::optional<LcmPacket> ReadLcmPacket(std::span<const std::byte> datagram) {
  if (datagram.size() <= kHeader || ReadBigEndian(datagram) != kMagic) return std::nullopt;
  const std::span<const std::byte> rest = datagram.subspan(kHeader);
  const auto channel = ReadChannel(rest);
  if (!channel) return std::nullopt;
  LcmPacket packet;
  packet.sequence = ReadBigEndian(datagram.subspan(4));
  packet.channel = *channel;
  packet.data = rest.subspan(channel->size() + 1);
  return packet;
}

std::optional<LcmFragment> ReadLcmFragment(std::span<const std::byte> datagram) {
  if (datagram.size() <= kFragmentHeader || ReadBigEndian(datagram) != kFragmentMagic) {
    return std::nullopt;
  }
  LcmFragment fragment;
  fragment.message_size = ReadBigEndian(datagram.subspan(kFragmentSizeAt));
  constexpr std::byte kNone{0};
  const bool first =
      datagram[kFragmentNumberAt] == kNone && datagram[kFragmentNumberAt + 1] == kNone;
  if (!first) return fragment;
  const auto channel = ReadChannel(datagram.subspan(kFragmentHeader));
  if (!channel) return std::nullopt;
  fragment.channel = *channel;
  return fragment;
}

Result<std::vector<std::byte>> WriteLcmPacket(const LcmPacket& packet) {
  const std::string channel(packet.channel);
  if (channel.empty() || channel.size() > kLongestLcmChannel) {
    return Error{kCodeParametersInvalid,
                 "an LCM channel has a name of 1 to 63 characters, not '" + channel + "'"};
  }
  const std::size_t size = kHeader + channel.size() + 1 + packet.data.size();
  if (size > kLongestLcmDatagram) {
    return Error{kCodeParametersInvalid, "a message of " + std::to_string(packet.data.size()) +
                                             " bytes on LCM channel '" + channel +
                                             "' does not fit into one datagram of 65507 bytes"};
  }
  std::vector<std::byte> bytes;
  bytes.reserve(size);
  WriteBigEndian(kMagic, bytes);
  WriteBigEndian(packet.sequence, bytes);
  for (const char c : channel) bytes.push_back(static_cast<std::byte>(c));
  bytes.push_back(std::byte{0});
  bytes.insert(bytes.end(), packet.data.begin(), packet.data.end());
  return bytes;
}

Result<LcmUrl> ReadLcmUrl(std::string_view text) {
  constexpr std::string_view kScheme = "udpm://";
  constexpr std::string_view kTtl = "?ttl=";
  constexpr int kMostTtl = 255;
  const Error wrong{kCodeParametersInvalid,
                    "'" + std::string(text) +
                        "' is no LCM url: expected \"udpm://239.255.76.67:7671\", an IPv4 "
                        "multicast address and a port, and possibly \"?ttl=0\" to \"?ttl=255\""};
  if (!text.starts_with(kScheme)) return wrong;
  std::string_view rest = text.substr(kScheme.size());
  LcmUrl url;
  if (const std::size_t query = rest.find('?'); query != std::string_view::npos) {
    if (!rest.substr(query).starts_with(kTtl)) return wrong;
    url.ttl = NumberOf<int>(rest.substr(query + kTtl.size()));
    if (!url.ttl || *url.ttl < 0 || *url.ttl > kMostTtl) return wrong;
    rest = rest.substr(0, query);
  }
  const std::size_t colon = rest.find(':');
  if (colon == std::string_view::npos) return wrong;
  url.group = rest.substr(0, colon);
  const auto port = NumberOf<std::uint16_t>(rest.substr(colon + 1));
  if (!port || *port == 0 || !IsMulticast(url.group)) return wrong;
  url.port = *port;
  return url;
}

std::string ToText(const LcmUrl& url) {
  return "udpm://" + url.group + ":" + std::to_string(url.port);
}

}  // namespace musher::transport
