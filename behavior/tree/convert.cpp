#include "musher/behavior/tree/convert.hpp"

#include <algorithm>
#include <array>

namespace musher::tree {
namespace {

constexpr std::array<std::string_view, 5> kStatusNames = {"IDLE", "RUNNING", "SUCCESS", "FAILURE",
                                                          "SKIPPED"};
constexpr std::size_t kShownOfAValue = 60;

}  // namespace

std::string_view Name(Status status) {
  return kStatusNames[static_cast<std::size_t>(status)];
}

std::optional<std::string_view> JsonIn(std::string_view text) {
  constexpr std::string_view kBegin = "json:";
  const std::string_view trimmed = Trimmed(text);
  if (!trimmed.starts_with(kBegin)) return std::nullopt;
  return trimmed.substr(kBegin.size());
}

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

std::vector<std::string_view> Split(std::string_view text) {
  std::vector<std::string_view> parts;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(';'), text.size());
    parts.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parts;
}

Error NoValue(std::string_view text, std::string_view expected) {
  return {kCodeFailed, "'" + std::string(text.substr(0, kShownOfAValue)) +
                           "' is not valid: expected " + std::string(expected)};
}

Result<bool> Convert<bool>::FromText(std::string_view text) {
  const std::string_view word = Trimmed(text);
  if (word == "true" || word == "TRUE" || word == "True" || word == "1") return true;
  if (word == "false" || word == "FALSE" || word == "False" || word == "0") return false;
  return NoValue(text, "true or false");
}

Result<Status> Convert<Status>::FromText(std::string_view text) {
  for (std::size_t i = 0; i < kStatusNames.size(); ++i) {
    if (Trimmed(text) == kStatusNames[i]) return static_cast<Status>(i);
  }
  return NoValue(text, "SUCCESS, FAILURE, RUNNING or SKIPPED");
}

}  // namespace musher::tree
