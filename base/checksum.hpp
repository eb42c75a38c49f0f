#pragma once
// Detects a damaged text; no protection against deliberate changes.

#include <cstdint>
#include <string_view>

namespace musher {

// FNV-1a, 64 bits.
constexpr std::uint64_t Fnv1a(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

}  // namespace musher
