#pragma once
// A large number for people.

#include <cstdint>
#include <string>

namespace musher::cli {

// 1234567 as "1,234,567".
inline std::string Grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

}  // namespace musher::cli
