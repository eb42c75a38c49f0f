#include "musher/behavior/skill/value.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

namespace musher::skill {
namespace {

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

template <class T>
std::optional<T> ParseNumber(std::string_view text) {
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<double> ParseFinite(std::string_view text) {
  const auto number = ParseNumber<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::optional<Numbers> ParseNumbers(std::string_view text) {
  if (text.size() < 2 || text.front() != '[' || text.back() != ']') return std::nullopt;
  text = text.substr(1, text.size() - 2);
  Numbers numbers;
  if (Trimmed(text).empty()) return numbers;
  for (;;) {
    const std::size_t comma = text.find(',');
    const auto number = ParseFinite(Trimmed(text.substr(0, comma)));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (comma == std::string_view::npos) return numbers;
    text.remove_prefix(comma + 1);
  }
}

std::optional<Value> ParseAs(Kind kind, std::string_view text) {
  const auto wrap = [](auto parsed) {
    return parsed ? std::optional<Value>(*parsed) : std::nullopt;
  };
  switch (kind) {
    case Kind::kBool:
      if (text != "true" && text != "false") return std::nullopt;
      return text == "true";
    case Kind::kInteger:
      return wrap(ParseNumber<std::int64_t>(text));
    case Kind::kNumber:
      return wrap(ParseFinite(text));
    case Kind::kNumbers:
      return wrap(ParseNumbers(text));
    case Kind::kText:
      break;
  }
  const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return std::string(quoted ? text.substr(1, text.size() - 2) : text);
}

bool IsFinite(const Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return std::isfinite(*number);
  const auto* numbers = std::get_if<Numbers>(&value);
  return numbers == nullptr ||
         std::ranges::all_of(*numbers, [](double number) { return std::isfinite(number); });
}

Error Expected(Kind kind, const std::string& found) {
  constexpr std::size_t kLongest = 60;
  return {kCodeParametersInvalid, "expected " + std::string(Name(kind)) + ", found " +
                                      found.substr(0, kLongest) +
                                      (found.size() > kLongest ? "..." : "")};
}

std::string NumberText(double number) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}

}  // namespace

std::string_view Name(Kind kind) {
  constexpr std::array<std::string_view, 5> kNames{"true or false", "an integer", "a number",
                                                   "a text", "a list of numbers"};
  return kNames[static_cast<std::size_t>(kind)];
}

Kind KindOf(const Value& value) {
  return static_cast<Kind>(value.index());
}

Result<Value> As(Kind kind, const Value& value) {
  if (KindOf(value) == kind && IsFinite(value)) return value;
  if (const auto* whole = std::get_if<std::int64_t>(&value); whole && kind == Kind::kNumber) {
    return Value(static_cast<double>(*whole));
  }
  return Expected(kind, ToText(value));
}

Result<Value> Parse(Kind kind, std::string_view text) {
  const auto parsed = ParseAs(kind, Trimmed(text));
  if (!parsed) return Expected(kind, std::string(text));
  return *parsed;
}

std::string ToText(const Value& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
  if (const auto* number = std::get_if<double>(&value)) return NumberText(*number);
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  std::string list;
  for (const double number : std::get<Numbers>(value)) {
    list += (list.empty() ? "" : ", ") + NumberText(number);
  }
  return "[" + list + "]";
}

const Value* Values::Find(std::string_view name) const {
  const auto found = std::ranges::find(values_, name, &Named::name);
  return found == values_.end() ? nullptr : &found->value;
}

void Values::Set(std::string_view name, Value value) {
  const auto found = std::ranges::find(values_, name, &Named::name);
  if (found == values_.end()) {
    values_.push_back({std::string(name), std::move(value)});
  } else {
    found->value = std::move(value);
  }
}

void Values::Remove(std::string_view name) {
  std::erase_if(values_, [&](const Named& named) { return named.name == name; });
}

}  // namespace musher::skill
