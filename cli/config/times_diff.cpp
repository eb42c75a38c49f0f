#include "musher/cli/config/times_diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/text.hpp"

namespace musher::cli {
namespace {

constexpr std::string_view kMarkOfUtf8 = "\xef\xbb\xbf";
constexpr std::size_t kContextLines = 3;

// Lines with their ends; the last one may have none.
std::vector<std::string> LinesWithEnds(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::size_t size = end == std::string_view::npos ? text.size() : end + 1;
    lines.emplace_back(text.substr(0, size));
    text.remove_prefix(size);
  }
  return lines;
}

// The byte at which a column, in characters from 1, begins.
std::size_t ByteOfColumn(std::string_view line, int column) {
  std::size_t byte = 0;
  for (int i = 1; i < column && byte < line.size(); ++i) {
    byte += std::max<std::size_t>(1, config_toml::CharacterSize(line.substr(byte)));
  }
  return byte;
}

bool IsOfNumber(char c) {
  return (c >= '0' && c <= '9') || c == '_' || c == '+';
}

// A limit in the text, and what it becomes.
struct NewLimit {
  config_toml::Position at;
  std::int64_t old_ms = 0;
  std::int64_t new_ms = 0;
};

// Replaces the number; false: it is not written in decimal.
bool ReplaceLimit(std::string& line, const NewLimit& limit) {
  const std::size_t begin = ByteOfColumn(line, limit.at.column);
  std::size_t end = begin;
  std::string digits;
  for (; end < line.size() && IsOfNumber(line[end]); ++end) {
    if (line[end] >= '0' && line[end] <= '9') digits += line[end];
  }
  if (digits != std::to_string(limit.old_ms)) return false;
  line.replace(begin, end - begin, std::to_string(limit.new_ms));
  return true;
}

// The elements of the array `times` of an actuator; null: there is none.
const config_toml::Array* TimesArray(const config_toml::Table& root, const std::string& actuator) {
  const config_toml::Table* table = &root;
  for (const std::string& key : {std::string("actuator"), actuator}) {
    const auto* member = config_toml::Find(*table, key);
    table = member == nullptr ? nullptr : member->value.As<config_toml::Table>();
    if (table == nullptr) return nullptr;
  }
  const auto* times = config_toml::Find(*table, "times");
  return times == nullptr ? nullptr : times->value.As<config_toml::Array>();
}

// In the order of the text.
std::vector<NewLimit> NewLimits(const config_toml::Table& root, const MachineConfig& config,
                                const std::vector<LearnedTime>& learned) {
  std::vector<NewLimit> limits;
  for (const ActuatorConfig& actuator : config.actuators) {
    const std::vector<std::int64_t> proposed_ms = ProposedLimits(actuator, learned);
    const auto* times = TimesArray(root, actuator.name);
    if (times == nullptr || times->size() != proposed_ms.size()) continue;
    for (std::size_t i = 0; i < proposed_ms.size(); ++i) {
      const std::int64_t old_ms = ToMilliseconds(actuator.times[i]);
      if (proposed_ms[i] != old_ms) limits.push_back({(*times)[i].at, old_ms, proposed_ms[i]});
    }
  }
  std::ranges::sort(limits, [](const NewLimit& a, const NewLimit& b) { return a.at < b.at; });
  return limits;
}

std::string DiffLine(char sign, const std::string& line) {
  return sign + line + (line.ends_with('\n') ? "" : "\n\\ No newline at end of file\n");
}

// Lines from `begin` to before `end`: what is removed stands before what is added.
std::string Hunk(const std::vector<std::string>& before, const std::vector<std::string>& after,
                 std::size_t begin, std::size_t end) {
  std::string text = fmt::format("@@ -{0},{1} +{0},{1} @@\n", begin + 1, end - begin);
  std::string added;
  for (std::size_t i = begin; i < end; ++i) {
    if (before[i] != after[i]) {
      text += DiffLine('-', before[i]);
      added += DiffLine('+', after[i]);
      continue;
    }
    text += std::exchange(added, "") + DiffLine(' ', before[i]);
  }
  return text + added;
}

// Of texts with equally many lines, which differ in some of them.
std::string UnifiedDiff(const std::vector<std::string>& before,
                        const std::vector<std::string>& after, const std::string& name) {
  std::string text;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] == after[i]) continue;
    const std::size_t begin = i - std::min(i, kContextLines);
    std::size_t last = i;  // that differs, in this hunk
    for (++i; i < before.size() && i <= last + 2 * kContextLines; ++i) {
      if (before[i] != after[i]) last = i;
    }
    const std::size_t end = std::min(before.size(), last + kContextLines + 1);
    text += Hunk(before, after, begin, end);
    i = last;
  }
  if (text.empty()) return "";
  // `patch` takes what stands before a tab for the name, also where that has spaces.
  const std::string head = name + (name.find(' ') == std::string::npos ? "\n" : "\t\n");
  return "--- " + head + "+++ " + head + text;
}

}  // namespace

Result<std::string> TimesDiff(std::string_view text, const MachineConfig& config,
                              const std::vector<LearnedTime>& learned, const std::string& name) {
  const bool marked = text.starts_with(kMarkOfUtf8);
  const std::string_view content = text.substr(marked ? kMarkOfUtf8.size() : 0);
  const auto document = config_toml::ParseDocument(content);
  const auto* root = std::get_if<config_toml::Table>(&document);
  MUSHER_CHECK(root != nullptr, "the config was valid");
  std::vector<std::string> before = LinesWithEnds(content);
  std::vector<std::string> after = before;
  std::vector<NewLimit> limits = NewLimits(*root, config, learned);
  // From the last one on: the columns of those before it stay as they are.
  for (; !limits.empty(); limits.pop_back()) {
    const NewLimit& limit = limits.back();
    const auto line = static_cast<std::size_t>(limit.at.line);
    if (line >= 1 && line <= after.size() && ReplaceLimit(after[line - 1], limit)) continue;
    return Error{kCodeParametersInvalid,
                 fmt::format("{}:{}: the limit {} is not written as a decimal number", name,
                             limit.at.line, limit.old_ms)};
  }
  if (marked && !before.empty()) {
    for (auto* lines : {&before, &after}) lines->front().insert(0, kMarkOfUtf8);
  }
  return UnifiedDiff(before, after, name);
}

}  // namespace musher::cli
