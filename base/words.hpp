#pragma once
// Parts of sentences for people.

#include <cstddef>
#include <string>
#include <string_view>

namespace musher {

// "1 number", "7 numbers"; `plural` where an s is not enough.
inline std::string Counted(std::size_t count, std::string_view what, std::string_view plural = "") {
  std::string text = std::to_string(count) + " ";
  if (count == 1) return text.append(what);
  if (!plural.empty()) return text.append(plural);
  return text.append(what).append("s");
}

// "the default namespace", "namespace 'fleet'"
inline std::string NamespaceText(std::string_view name_space) {
  if (name_space.empty()) return "the default namespace";
  return "namespace '" + std::string(name_space) + "'";
}

}  // namespace musher
