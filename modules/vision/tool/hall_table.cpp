#include "musher/modules/vision/tool/hall_table.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace musher::vision::tool {
namespace {

constexpr std::string_view kSpace = " \t\r";

std::string_view Trimmed(std::string_view line) {
  const std::size_t from = line.find_first_not_of(kSpace);
  if (from == std::string_view::npos) return {};
  return line.substr(from, line.find_last_not_of(kSpace) - from + 1);
}

// Where a comment begins; the line's length without one. No value of [hall] has a text.
std::size_t CommentAt(std::string_view line) {
  return std::min(line.find('#'), line.size());
}

bool IsHeader(std::string_view line, std::string_view name) {
  return Trimmed(line.substr(0, CommentAt(line))) == name;
}

// The key of a line "key = value"; empty: it has none.
std::string_view KeyOf(std::string_view line) {
  const std::string_view code = line.substr(0, CommentAt(line));
  const std::size_t equals = code.find('=');
  return equals == std::string_view::npos ? std::string_view() : Trimmed(code.substr(0, equals));
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t from = 0;
  while (from < text.size()) {
    const std::size_t to = std::min(text.find('\n', from), text.size());
    lines.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return lines;
}

// The line with another value, and its comment.
std::string WithValue(const std::string& line, const HallKey& key) {
  const std::size_t comment = CommentAt(line);
  const std::string indent = line.substr(0, line.find_first_not_of(kSpace));
  const std::string behind = comment < line.size() ? "  " + line.substr(comment) : "";
  return indent + key.key + " = " + key.value + behind;
}

bool IsWhole(std::string_view line) {
  const std::string_view code = line.substr(0, CommentAt(line));
  const auto count = [&](char c) { return std::ranges::count(code, c); };
  return count('[') == count(']') && count('{') == count('}');
}

}  // namespace

Result<HallChange> WithHallKeys(const std::string& text, const std::vector<HallKey>& keys) {
  std::vector<std::string> lines = LinesOf(text);
  const auto is_hall = [](const std::string& line) { return IsHeader(line, "[hall]"); };
  auto header = std::ranges::find_if(lines, is_hall);
  if (header == lines.end()) {
    if (!lines.empty()) lines.emplace_back();
    lines.emplace_back("[hall]");
    header = lines.end() - 1;
  }
  const auto begin = static_cast<std::size_t>(header - lines.begin()) + 1;
  const auto next =
      std::find_if(lines.begin() + std::ptrdiff_t(begin), lines.end(),
                   [](const std::string& line) { return Trimmed(line).starts_with("["); });
  const auto end = static_cast<std::size_t>(next - lines.begin());
  HallChange change;
  std::vector<std::string> added;
  for (const HallKey& key : keys) {
    std::size_t at = begin;
    while (at < end && KeyOf(lines[at]) != key.key) ++at;
    if (at == end) {
      added.push_back(key.key + " = " + key.value);
      continue;
    }
    if (!IsWhole(lines[at])) {
      return Error{kCodeFailed, key.key + " of [hall] is on several lines: change it by hand"};
    }
    change.before.push_back(lines[at]);
    lines[at] = WithValue(lines[at], key);
  }
  lines.insert(lines.begin() + std::ptrdiff_t(begin), added.begin(), added.end());
  for (const std::string& line : lines) change.text += line + "\n";
  return change;
}

}  // namespace musher::vision::tool
