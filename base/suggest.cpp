#include "musher/base/suggest.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace musher {
namespace {

constexpr std::size_t kMostNames = 12;                   // that are listed
using Row = std::array<std::uint8_t, kLongestWord + 1>;  // distances, at most kLongestWord

char Lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

// "DeActive" and "inactive" for "Active": who types the one does not mean the other.
bool IsOpposite(std::string_view word, std::string_view candidate) {
  constexpr std::size_t kPrefix = 2;
  if (word.size() != candidate.size() + kPrefix) return false;
  const auto same = [](char a, char b) { return Lower(a) == Lower(b); };
  const auto begins = [&](std::string_view prefix) {
    return std::ranges::equal(word.substr(0, kPrefix), prefix, same);
  };
  return (begins("de") || begins("in") || begins("un")) &&
         std::ranges::equal(word.substr(kPrefix), candidate, same);
}

// Optimal string alignment distance; anything over `limit` is given as limit + 1.
std::size_t Distance(std::string_view a, std::string_view b, std::size_t limit) {
  const std::size_t longer = std::max(a.size(), b.size());
  if (longer > kLongestWord || longer - std::min(a.size(), b.size()) > limit) return limit + 1;
  Row before_last{};
  Row last{};
  Row row{};
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = static_cast<std::uint8_t>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<std::uint8_t>(i);
    std::size_t best = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (Lower(a[i - 1]) == Lower(b[j - 1]) ? 0U : 1U);
      std::size_t edits =
          std::min({replaced, last[j] + std::size_t{1}, row[j - 1] + std::size_t{1}});
      const bool swapped = i > 1 && j > 1 && Lower(a[i - 1]) == Lower(b[j - 2]) &&
                           Lower(a[i - 2]) == Lower(b[j - 1]);
      if (swapped) edits = std::min(edits, before_last[j - 2] + std::size_t{1});
      row[j] = static_cast<std::uint8_t>(edits);
      best = std::min(best, edits);
    }
    if (best > limit) return limit + 1;
    before_last = last;
    last = row;
  }
  return std::min<std::size_t>(last[b.size()], limit + 1);
}

}  // namespace

std::string Nearest(std::string_view word, const std::vector<std::string_view>& candidates) {
  if (word.empty() || word.size() > kLongestWord) return {};
  std::size_t limit = std::clamp<std::size_t>(word.size() / 3, 1, 3);
  std::string_view nearest;
  for (const std::string_view candidate : candidates) {
    if (candidate == word || IsOpposite(word, candidate)) continue;
    const std::size_t distance = Distance(word, candidate, limit);
    if (distance > limit) continue;
    nearest = candidate;
    if (distance == 0) break;
    limit = distance - 1;
  }
  return std::string(nearest);
}

std::string DidYouMean(const std::string& quoted_name) {
  return "; did you mean " + quoted_name + "?";
}

std::string DidYouMean(std::string_view word, const std::vector<std::string_view>& names,
                       std::string_view quotes) {
  const std::string nearest = Nearest(word, names);
  return nearest.empty() ? "" : DidYouMean(quotes.front() + nearest + quotes.back());
}

std::string NoSuch(std::string_view what, std::string_view name,
                   const std::vector<std::string>& names) {
  return "there is no " + std::string(what) + " '" + std::string(name.substr(0, kLongestWord)) +
         "'" + KnownNames(name, names);
}

std::string KnownNames(std::string_view name, const std::vector<std::string>& names) {
  if (names.empty()) return "";
  const std::string hint = DidYouMean(name, names);
  std::string text = hint.empty() ? "; there " : hint + " There ";
  text += names.size() == 1 ? "is only " : "are ";
  const std::size_t shown = std::min(names.size(), kMostNames);
  for (std::size_t i = 0; i < shown; ++i) {
    const bool last = i + 1 == names.size();
    text += (i == 0 ? "" : last ? " and " : ", ") + names[i];
  }
  return shown == names.size() ? text
                               : text + " and " + std::to_string(names.size() - shown) + " more";
}

}  // namespace musher
