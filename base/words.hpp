#pragma once
// Parts of sentences for people, and of commands that they copy.

#include <cstddef>
#include <string>
#include <string_view>

namespace musher {

// "number" of 1, "numbers" of 7; `plural` where an s is not enough.
inline std::string NounOf(std::size_t count, std::string_view what, std::string_view plural = "") {
  if (count == 1) return std::string(what);
  return plural.empty() ? std::string(what) + "s" : std::string(plural);
}

// "1 number", "7 numbers"
inline std::string Counted(std::size_t count, std::string_view what, std::string_view plural = "") {
  return std::to_string(count) + " " + NounOf(count, what, plural);
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
