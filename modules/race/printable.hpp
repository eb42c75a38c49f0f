#pragma once
// Texts from the network in a log or in state_info: they are short, and have no control characters,
// which could end a line or forge one. UTF-8 stays. Pure. Threads: any.

#include <algorithm>
#include <string>
#include <string_view>

namespace musher::race {

inline constexpr std::size_t kMostShown = 40;  // bytes of one text

inline std::string Printable(std::string_view text, std::size_t most = kMostShown) {
  std::string shown(text.substr(0, most));
  std::ranges::replace_if(
      shown, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f; }, '?');
  return shown;
}

}  // namespace musher::race
