#include "musher/test/house/text_rules.hpp"

#include <cctype>
#include <regex>

namespace musher::house {
namespace {

constexpr std::size_t kMostLines = 400;

std::vector<std::string> Find(const SourceFile& file, const std::string& text,
                              const std::regex& pattern, const std::string& violation) {
  std::vector<std::string> violations;
  for (const Line& line : Lines(text)) {
    std::smatch match;
    if (std::regex_search(line.text, match, pattern)) {
      violations.push_back(At(file, line.number, match.str() + " " + violation));
    }
  }
  return violations;
}

}  // namespace

std::vector<std::string> Impurities(const SourceFile& file) {
  static const std::regex impure(
      R"(::now\(|std::(jthread|thread|async|mutex|condition_variable|atomic)\b|\bsocket\()"
      R"(|\b(secure_)?getenv\()"
      R"(|#\s*include\s*<(thread|mutex|condition_variable|atomic|future|sys/socket\.h|dds/.*)>)");
  return Find(file, WithoutComments(file.text), impure, "has no place in pure code");
}

std::vector<std::string> Sleeps(const SourceFile& file) {
  static const std::regex sleep(R"(\b(sleep_for|sleep_until|usleep|nanosleep)\b|[^_.\w"]sleep\()");
  return Find(file, WithoutComments(file.text), sleep, "waits for a time instead of an event");
}

std::vector<std::string> ThrowingIterators(const SourceFile& file) {
  static const std::regex throwing(
      R"(\bistreambuf_iterator\b|(: |distance\()[\w:]*\bdirectory_iterator\()");
  return Find(file, WithoutComments(file.text), throwing, "may throw; base/files.hpp does not");
}

std::vector<std::string> Leftovers(const SourceFile& file) {
  // In two parts, so that this file does not find itself.
  static const std::regex leftover(
      "\\b(TO"
      "DO|FIX"
      "ME|XX"
      "X)\\b");
  return Find(file, file.text, leftover, "is left over");
}

std::map<std::string, std::string> ReadPrivateWords(const std::string& text) {
  std::map<std::string, std::string> words;
  for (const Line& line : Lines(text)) {
    const std::size_t colon = line.text.find(": ");
    if (line.text.starts_with('#') || colon == std::string::npos) continue;
    words.emplace(line.text.substr(0, colon), line.text.substr(colon + 2));
  }
  return words;
}

std::vector<std::string> PrivateWords(const SourceFile& file,
                                      const std::map<std::string, std::string>& words) {
  std::vector<std::string> violations;
  for (const Line& line : Lines(file.text)) {
    std::string word;
    const auto end_word = [&] {
      const auto found = words.find(word);
      if (found != words.end()) {
        violations.push_back(At(file, line.number, "'" + word + "'; say: " + found->second));
      }
      word.clear();
    };
    for (const char c : line.text) {
      if (std::islower(static_cast<unsigned char>(c)) == 0) end_word();
      if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
        word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      }
    }
    end_word();
  }
  return violations;
}

std::vector<std::string> Oversize(const SourceFile& file) {
  const std::size_t lines = Lines(file.text).size();
  if (lines <= kMostLines) return {};
  return {file.path + ": " + std::to_string(lines) + " lines; more than " +
          std::to_string(kMostLines) + "; split it"};
}

std::vector<std::string> MissingPragmaOnce(const SourceFile& file) {
  for (const Line& line : Lines(file.text)) {
    if (line.text == "#pragma once") return {};
  }
  return {file.path + ": has no #pragma once"};
}

std::vector<std::string> NotExecutable(const SourceFile& file) {
  if (!file.text.starts_with("#!") || file.executable) return {};
  return {file.path + ": is a script but not executable"};
}

}  // namespace musher::house
