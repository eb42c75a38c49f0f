#include "musher/ota/version.hpp"

#include <algorithm>
#include <charconv>

namespace musher::ota {
namespace {

constexpr std::size_t kLongest = 100;  // characters

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

bool IsNumber(std::string_view word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), IsDigit);
}

// Without leading zeros, and within the range of the type.
std::optional<std::uint64_t> Number(std::string_view word) {
  if (!IsNumber(word) || (word.size() > 1 && word.front() == '0')) return std::nullopt;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc()) return std::nullopt;
  return number;
}

bool IsIdentifier(std::string_view word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
    return IsDigit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-';
  });
}

std::vector<std::string_view> Split(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t dot = text.find('.');
    words.push_back(text.substr(0, dot));
    if (dot == std::string_view::npos) return words;
    text.remove_prefix(dot + 1);
  }
}

// Compares numbers by value and words by characters; numbers precede words.
std::strong_ordering CompareIdentifiers(const std::string& a, const std::string& b) {
  if (IsNumber(a) != IsNumber(b)) {
    return IsNumber(a) ? std::strong_ordering::less : std::strong_ordering::greater;
  }
  if (IsNumber(a) && a.size() != b.size()) return a.size() <=> b.size();
  return a <=> b;
}

}  // namespace

std::strong_ordering Compare(const Version& a, const Version& b) {
  if (const auto order = a.major <=> b.major; std::is_neq(order)) return order;
  if (const auto order = a.minor <=> b.minor; std::is_neq(order)) return order;
  if (const auto order = a.patch <=> b.patch; std::is_neq(order)) return order;
  if (a.pre_release.empty() || b.pre_release.empty()) {
    return b.pre_release.size() <=> a.pre_release.size();  // without one is newer
  }
  const std::size_t common = std::min(a.pre_release.size(), b.pre_release.size());
  for (std::size_t i = 0; i < common; ++i) {
    const auto order = CompareIdentifiers(a.pre_release[i], b.pre_release[i]);
    if (std::is_neq(order)) return order;
  }
  return a.pre_release.size() <=> b.pre_release.size();
}

std::optional<Version> ParseVersion(std::string_view text) {
  if (text.size() > kLongest) return std::nullopt;
  Version version;
  version.text = text;
  const std::size_t plus = text.find('+');
  if (plus != std::string_view::npos) {
    const auto build = Split(text.substr(plus + 1));
    if (!std::all_of(build.begin(), build.end(), IsIdentifier)) return std::nullopt;
    text = text.substr(0, plus);
  }
  const std::size_t dash = text.find('-');
  if (dash != std::string_view::npos) {
    for (const std::string_view word : Split(text.substr(dash + 1))) {
      if (!IsIdentifier(word)) return std::nullopt;
      if (IsNumber(word) && word.size() > 1 && word.front() == '0') return std::nullopt;
      version.pre_release.emplace_back(word);
    }
    text = text.substr(0, dash);
  }
  const auto numbers = Split(text);
  if (numbers.size() != 3) return std::nullopt;
  const auto major = Number(numbers[0]);
  const auto minor = Number(numbers[1]);
  const auto patch = Number(numbers[2]);
  if (!major || !minor || !patch) return std::nullopt;
  version.major = *major;
  version.minor = *minor;
  version.patch = *patch;
  return version;
}

}  // namespace musher::ota
