#include "musher/modules/race/recording.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace musher::race {
namespace {

constexpr std::string_view kNothing = "-";

template <class Number>
Result<Number> Read(std::string_view word) {
  Number number{};
  const char* end = word.data() + word.size();
  const auto [read, error] = std::from_chars(word.data(), end, number);
  if (error == std::errc() && read == end) return number;
  return Error{kCodeFailed, "expected a number, found '" + std::string(word.substr(0, 40)) + "'"};
}

// Takes the first word, or the rest of the text.
std::string_view Take(std::string_view& text, bool rest) {
  const std::size_t end = rest ? text.size() : text.find(' ');
  const std::string_view word = text.substr(0, end);
  text.remove_prefix(std::min(text.size(), word.size() + 1));
  return word;
}

constexpr std::array<std::pair<char, std::string_view>, 3> kCodes = {
    {{' ', "%20"}, {'%', "%25"}, {'-', "%2D"}}};

// A word that has no space, and is not that of nothing.
std::string Encoded(const std::string& word) {
  if (word.empty()) return std::string(kNothing);
  std::string text;
  for (const char c : word) {
    const auto* const code =
        std::ranges::find_if(kCodes, [c](const auto& known) { return known.first == c; });
    const bool bare = code == kCodes.end() || (c == '-' && word != kNothing);
    text += bare ? std::string(1, c) : std::string(code->second);
  }
  return text;
}

std::string Decoded(std::string_view text) {
  if (text == kNothing) return {};
  std::string word;
  while (!text.empty()) {
    const auto* const code = std::ranges::find_if(
        kCodes, [text](const auto& known) { return text.starts_with(known.second); });
    word += code == kCodes.end() ? text.front() : code->first;
    text.remove_prefix(code == kCodes.end() ? 1 : code->second.size());
  }
  return word;
}

}  // namespace

std::string NumberText(double number) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  return {digits.data(), end};
}

std::string InputText(Duration at, std::initializer_list<std::string> words) {
  std::string text = std::to_string(at.count());
  for (const std::string& word : words) {
    const bool last = &word == words.end() - 1;
    text += " " + (last && !word.empty() ? word : Encoded(word));
  }
  return text;
}

Result<InputWords> ReadInput(std::string_view text, std::size_t words) {
  const Error fault{kCodeFailed, "expected a time in ns and " + std::to_string(words) +
                                     " words, found '" + std::string(text.substr(0, 80)) + "'"};
  InputWords read;
  const Result<std::int64_t> at = Read<std::int64_t>(Take(text, false));
  if (!at) return fault;
  read.at = Duration(at.value());
  for (std::size_t i = 0; i < words; ++i) {
    const bool last = i + 1 == words;
    const std::string_view word = Take(text, last);
    if (word.empty()) return fault;
    read.words.push_back(last && word != kNothing ? std::string(word) : Decoded(word));
  }
  return read;
}

Result<std::int64_t> ReadInteger(std::string_view word) {
  return Read<std::int64_t>(word);
}

Result<double> ReadNumber(std::string_view word) {
  return Read<double>(word);
}

}  // namespace musher::race
