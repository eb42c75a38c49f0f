#include "musher/cli/render/log_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

#include "musher/cli/console/console.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"

namespace musher::cli {
namespace {

bool IsDigitOfTime(char c) {
  return c >= '0' && c <= '9';
}

// The length of "Z", "+01:00" or "+0100" at the begin; 0: there is no time zone.
std::size_t LengthOfZone(std::string_view text) {
  if (text.starts_with('Z')) return 1;
  if (!text.starts_with('+') && !text.starts_with('-')) return 0;
  for (const std::string_view pattern : {"+dd:dd", "+dddd"}) {
    const std::string_view zone = text.substr(0, pattern.size());
    const bool fits =
        std::equal(zone.begin() + 1, zone.end(), pattern.begin() + 1, pattern.end(),
                   [](char c, char p) { return p == 'd' ? IsDigitOfTime(c) : c == p; });
    if (fits) return pattern.size();
  }
  return 0;
}

// The length of "2026-03-01 13:00:05.250" at the begin; 0: there is no time. A comma, 'T', or a
// time zone, as other programs write them, too.
std::size_t LengthOfTime(std::string_view text) {
  constexpr std::string_view kPattern = "dddd-dd-dd dd:dd:dd";
  if (text.size() < kPattern.size()) return 0;
  for (std::size_t i = 0; i < kPattern.size(); ++i) {
    const char p = kPattern[i];
    const bool fits = p == 'd'   ? IsDigitOfTime(text[i])
                      : p == ' ' ? text[i] == ' ' || text[i] == 'T'
                                 : text[i] == p;
    if (!fits) return 0;
  }
  std::size_t size = kPattern.size();
  if (size < text.size() && (text[size] == '.' || text[size] == ',')) {
    for (++size; size < text.size() && IsDigitOfTime(text[size]);) ++size;
  }
  return size + LengthOfZone(text.substr(size));
}

std::optional<std::int64_t> TimeIn(std::string_view text) {
  std::string time(text);
  std::replace(time.begin(), time.end(), ',', '.');
  const auto parsed = ParseSince(time, 0);
  if (!parsed) return std::nullopt;
  return parsed.value();
}

// Takes "[...] " from the front; nullopt: it is not there.
std::optional<std::string_view> TakeBracket(std::string_view& text) {
  if (!text.starts_with('[')) return std::nullopt;
  const std::size_t end = text.find(']');
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view inner = text.substr(1, end - 1);
  text.remove_prefix(end + 1);
  if (text.starts_with(' ')) text.remove_prefix(1);
  return inner;
}

std::optional<LogLevel> LevelOf(std::string_view word) {
  std::string lower(word);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  if (lower == "warn") return LogLevel::kWarning;
  if (lower == "fatal" || lower == "critical" || lower == "err") return LogLevel::kError;
  return LogLevelNamed(lower);
}

// "1772366405.250000000"
std::optional<std::int64_t> SecondsIn(std::string_view text) {
  std::int64_t seconds = 0;
  std::int64_t fraction = 0;
  const char* const end = text.data() + text.size();
  const auto whole = std::from_chars(text.data(), end, seconds);
  constexpr std::int64_t kFarthest = 9'000'000'000;
  if (whole.ec != std::errc() || whole.ptr == end || *whole.ptr != '.') return std::nullopt;
  const auto rest = std::from_chars(whole.ptr + 1, end, fraction);
  if (rest.ec != std::errc() || rest.ptr != end || end - whole.ptr != 10) return std::nullopt;
  if (seconds < 1'000'000'000 || seconds > kFarthest || fraction < 0) return std::nullopt;
  return seconds * 1'000'000'000 + fraction;
}

struct ParsedLine {
  std::optional<std::int64_t> wall_ns;
  std::optional<LogLevel> level;
  std::string_view text;
};

// "[WARN] [1772366405.250000000] [talker]: slow", "[2026-03-01 13:00:05.250] [legs] [warning] hot"
std::optional<ParsedLine> InBrackets(std::string_view line) {
  ParsedLine parsed{{}, {}, line};
  std::string_view rest = line;
  while (const auto inner = TakeBracket(rest)) {
    const auto level = LevelOf(*inner);
    const std::size_t size = LengthOfTime(*inner);
    const auto time = size != 0 && size == inner->size() ? TimeIn(*inner) : SecondsIn(*inner);
    if (level) parsed.level = level;
    if (time) parsed.wall_ns = time;
    if (level || time) parsed.text = rest;
  }
  if (!parsed.level && !parsed.wall_ns) return std::nullopt;
  return parsed;
}

// "gripper: warning: hot", "warning: hot"; "info: " is taken away.
std::optional<LogLevel> TakeLevel(std::string_view& text, std::string_view source) {
  if (text.starts_with(source) && text.substr(source.size()).starts_with(": ")) {
    text.remove_prefix(source.size() + 2);
  }
  const std::size_t end = text.find(": ");
  if (end != std::string_view::npos) {
    const auto level = LogLevelNamed(text.substr(0, end));
    if (level == LogLevel::kInfo) text.remove_prefix(end + 2);
    if (level) return level;
  }
  for (const auto& [word, level] :
       {std::pair{": error: ", LogLevel::kError}, std::pair{": warning: ", LogLevel::kWarning}}) {
    if (text.find(word) != std::string_view::npos) return level;
  }
  return std::nullopt;
}

ParsedLine ParseLogLine(std::string_view line, std::string_view source) {
  if (const auto parsed = InBrackets(line)) return *parsed;
  ParsedLine parsed{{}, {}, line};
  const std::size_t size = LengthOfTime(line);
  if (size != 0) parsed.wall_ns = TimeIn(line.substr(0, size));
  if (parsed.wall_ns) {
    parsed.text.remove_prefix(size);
    if (parsed.text.starts_with(' ')) parsed.text.remove_prefix(1);
  }
  const std::string_view before = parsed.text;
  parsed.level = TakeLevel(parsed.text, source);
  const bool begins = parsed.wall_ns || parsed.level || before.size() != parsed.text.size();
  if (begins && !parsed.level) parsed.level = LogLevel::kInfo;
  return parsed;
}

// Without the sequences by which programs colour their lines ("\x1b[31m").
std::string WithoutEscapes(std::string_view text) {
  std::string plain;
  plain.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\x1b' || i + 1 >= text.size() || text[i + 1] != '[') {
      plain += text[i];
      continue;
    }
    for (i += 2; i < text.size() && (text[i] < '@' || text[i] > '~');) ++i;
  }
  return plain;
}

Style StyleOfLevel(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return Style::kDim;
    case LogLevel::kWarning:
      return Style::kBusy;
    case LogLevel::kError:
      return Style::kBad;
    case LogLevel::kInfo:
      break;
  }
  return Style::kPlain;
}

constexpr std::array<const char*, 4> kLevelNames = {"debug", "info", "warning", "error"};

}  // namespace

LogEntry LogLines::Take(const WrittenLine& written) {
  const std::string plain = WithoutEscapes(written.text);
  std::string_view line = plain;
  if (line.ends_with('\r')) line.remove_suffix(1);
  const ParsedLine parsed = ParseLogLine(line, source_);
  // A line that is indented continues the message before it.
  const bool continues = !parsed.level && (line.starts_with(' ') || line.starts_with('\t'));
  if (!continues) level_ = parsed.level.value_or(LogLevel::kInfo);
  return {source_, parsed.wall_ns.value_or(written.written_ns), level_, std::string(parsed.text)};
}

std::vector<LogEntry> LogEntriesOf(const std::string& source,
                                   const std::vector<WrittenLine>& lines) {
  LogLines log(source);
  std::vector<LogEntry> entries;
  entries.reserve(lines.size());
  for (const WrittenLine& line : lines) entries.push_back(log.Take(line));
  return entries;
}

std::vector<LogEntry> Merge(std::vector<std::vector<LogEntry>> logs) {
  std::vector<std::pair<std::int64_t, LogEntry>> all;
  for (std::vector<LogEntry>& log : logs) {
    const auto first =
        std::find_if(log.begin(), log.end(), [](const auto& e) { return e.wall_ns; });
    std::int64_t time = first == log.end() ? 0 : first->wall_ns;
    for (LogEntry& e : log) {
      time = std::max(time, e.wall_ns);  // the wall clock may be set back
      all.emplace_back(time, std::move(e));
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<LogEntry> merged;
  merged.reserve(all.size());
  for (auto& [time, entry] : all) merged.push_back(std::move(entry));
  return merged;
}

std::string LogText(const LogEntry& entry, std::size_t width, bool colour) {
  constexpr std::size_t kTimeWidth = 23;
  const std::string time =
      entry.wall_ns == 0 ? std::string(kTimeWidth, ' ') : LocalText(entry.wall_ns);
  std::string text = Paint(time, Style::kDim, colour) + "  ";
  if (width != 0) {
    const std::string source = Printable(entry.source);
    text += Paint(source, Style::kBold, colour) +
            std::string(width - std::min(width, Width(source)) + 2, ' ');
  }
  return text + Paint(Printable(entry.text), StyleOfLevel(entry.level), colour) + '\n';
}

std::string LogJson(const LogEntry& entry) {
  return JsonLine(
      {{"time", entry.wall_ns == 0 ? OrderedJson() : OrderedJson(UtcText(entry.wall_ns))},
       {"actuator", entry.source},
       {"level", kLevelNames.at(static_cast<std::size_t>(entry.level))},
       {"message", entry.text}});
}

}  // namespace musher::cli
