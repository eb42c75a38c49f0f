#pragma once
// Names in a sentence: "legs, arm, head". Pure; from any thread.

#include <string>
#include <string_view>

namespace musher {

// `none` is the text for no names at all.
template <typename Names>  // a container of what converts to std::string_view
std::string Joined(const Names& names, std::string_view none = "") {
  if (names.begin() == names.end()) return std::string(none);
  std::string text;
  bool first = true;
  for (const std::string_view name : names) {
    if (!first) text += ", ";
    first = false;
    text += name;
  }
  return text;
}

}  // namespace musher
