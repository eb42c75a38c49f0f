#include "musher/modules/wedding/recording.hpp"

#include <array>
#include <charconv>

namespace musher::wedding {
namespace {

template <class Number>
void Append(std::string& text, Number number) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  if (!text.empty()) text += ' ';
  text.append(digits.data(), end);
}

// Parses a number at the front of `text` and removes it.
template <class Number>
bool Take(std::string_view& text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.empty() && text.front() != ' ') return false;
  if (!text.empty()) text.remove_prefix(1);
  return true;
}

}  // namespace

std::string InputText(Duration at, std::initializer_list<double> numbers) {
  std::string text;
  Append(text, at.count());
  for (const double number : numbers) Append(text, number);
  return text;
}

std::string InputText(Duration at, std::string_view word) {
  std::string text;
  Append(text, at.count());
  return text + " " + std::string(word);
}

Result<InputFields> ReadInput(std::string_view text, std::size_t numbers) {
  const Error fault{kCodeFailed, "expected a time in ns and " + std::to_string(numbers) +
                                     " numbers, found '" + std::string(text.substr(0, 80)) + "'"};
  InputFields fields;
  std::int64_t at_ns = 0;
  if (!Take(text, at_ns)) return fault;
  fields.at = Duration(at_ns);
  fields.word = text;
  for (std::size_t i = 0; i < numbers; ++i) {
    double number = 0;
    if (!Take(text, number)) return fault;
    fields.numbers.push_back(number);
  }
  return fields;
}

}  // namespace musher::wedding
