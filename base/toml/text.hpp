#pragma once
// Checks a text before it is parsed: it is UTF-8, and it does not exceed the limits that protect
// the parser.

#include <optional>
#include <string_view>

#include "musher/base/toml/document.hpp"

namespace musher::config_toml {

// Limits far beyond the needs of any machine. They keep parsing linear and recursion shallow.
inline constexpr int kDeepestNesting = 32;    // arrays and inline tables in each other
inline constexpr int kMostKeyParts = 32;      // of one dotted key
inline constexpr int kMostDots = 50'000;      // outside strings and comments
inline constexpr int kMostEntries = 500'000;  // keys, array elements and table headers

// The first byte that is not UTF-8, or the place where a limit is exceeded.
std::optional<SyntaxFault> FindTextFault(std::string_view text);

// The bytes of the UTF-8 character that `text` begins with, 0 where there is none.
std::size_t CharacterSize(std::string_view text);

}  // namespace musher::config_toml
