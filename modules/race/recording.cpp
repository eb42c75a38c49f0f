#include "musher/modules/race/recording.hpp"

#include <array>
#include <charconv>

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

}  // namespace

std::string NumberText(double number) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  return {digits.data(), end};
}

std::string InputText(Duration at, std::initializer_list<std::string> words) {
  std::string text = std::to_string(at.count());
  for (const std::string& word : words) {
    text += " " + (word.empty() ? std::string(kNothing) : word);
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
    const std::string_view word = Take(text, i + 1 == words);
    if (word.empty()) return fault;
    read.words.emplace_back(word == kNothing ? "" : word);
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
