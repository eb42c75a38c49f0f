#pragma once
// Parts of sentences for people, and of commands that they copy.

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

// A word of a command to copy, in quotes where a shell needs them: robot.toml, 'my robot.toml'.
inline std::string ShellWord(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:=@%+,";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos) {
    return std::string(word);
  }
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'') quoted += "'\\'";
    quoted += c;
  }
  return quoted + "'";
}

}  // namespace musher
