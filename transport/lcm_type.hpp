#pragma once
// The bytes of a message whose C++ type lcm-gen has made, as "robot_control_cmd_lcmt.hpp". Bytes
// from the network are not trusted: another type and a wrong length are errors with the reason.
//
// Pure functions. Threads: any.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::transport {

template <typename Wire>
std::vector<std::byte> EncodeLcm(const Wire& wire) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(wire.getEncodedSize()));
  wire.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

// The first bytes of a message: a hash of the names, types and order of its fields.
inline std::string LcmFingerprintText(std::uint64_t fingerprint) {
  char text[19];  // "0x" and 16 digits
  std::snprintf(text, sizeof text, "0x%016llx", static_cast<unsigned long long>(fingerprint));
  return text;
}

// Whether the bytes begin with the fingerprint of the type.
template <typename Wire>
Result<> CheckLcmType(std::span<const std::byte> bytes) {
  const std::string type = Wire::getTypeName();
  std::uint64_t found = 0;
  if (bytes.size() < sizeof found) {
    return Error{kCodeParametersInvalid, std::to_string(bytes.size()) + " bytes are no " + type};
  }
  for (const std::byte byte : bytes.first(sizeof found)) {
    found = found << 8 | std::to_integer<std::uint64_t>(byte);
  }
  const auto expected = static_cast<std::uint64_t>(Wire::getHash());
  if (found == expected) return Ok();
  return Error{kCodeParametersInvalid, "fingerprint " + LcmFingerprintText(found) +
                                           " is not that of " + type + ", " +
                                           LcmFingerprintText(expected) +
                                           ": the sender has another definition of the message"};
}

// Not for a type with a string: what lcm-gen makes of one trusts its length (DecodeLcmText).
template <typename Wire>
Result<Wire> DecodeLcm(std::span<const std::byte> bytes) {
  if (auto typed = CheckLcmType<Wire>(bytes); !typed) return typed.error();
  const std::string size =
      std::to_string(bytes.size()) + " bytes are no " + std::string(Wire::getTypeName());
  Wire wire{};
  const int read = wire.decode(bytes.data(), 0, static_cast<int>(bytes.size()));
  if (read < 0) return Error{kCodeParametersInvalid, size + ": too short"};
  if (read != static_cast<int>(bytes.size())) {
    return Error{kCodeParametersInvalid, size + ": too long"};
  }
  return wire;
}

// The text of a message whose only field is a string: a length in four bytes, the text, a zero
// byte.
template <typename Wire>
Result<std::string> DecodeLcmText(std::span<const std::byte> bytes) {
  if (auto typed = CheckLcmType<Wire>(bytes); !typed) return typed.error();
  std::span<const std::byte> rest = bytes.subspan(sizeof(std::uint64_t));
  std::uint32_t length = 0;
  const bool has_length = rest.size() > sizeof length;
  for (const std::byte byte : rest.first(has_length ? sizeof length : 0)) {
    length = length << 8 | std::to_integer<std::uint32_t>(byte);
  }
  rest = rest.subspan(has_length ? sizeof length : 0);
  if (!has_length || length != rest.size() || rest.back() != std::byte{0}) {
    return Error{kCodeParametersInvalid, std::to_string(bytes.size()) + " bytes are no " +
                                             Wire::getTypeName() + ": its text has another length"};
  }
  return std::string(reinterpret_cast<const char*>(rest.data()), rest.size() - 1);
}

}  // namespace musher::transport
