#include "musher/modules/race/toml_numbers.hpp"

#include <algorithm>
#include <charconv>

namespace musher::race {
namespace {

constexpr std::string_view kOfNumber = "0123456789.+-eE_";

bool IsOfName(char c) {
  return c == '_' || c == '-' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
         (c >= 'A' && c <= 'Z');
}

// Without a comment.
std::string_view CodeOf(std::string_view line) {
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] == '#' && !quoted) return line.substr(0, i);
  }
  return line;
}

std::string_view WithoutSpaces(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// The name in [name] and [[name]].
std::string_view HeaderOf(std::string_view code) {
  const std::size_t begin = code.find_first_not_of('[');
  const std::size_t end = code.find(']');
  return begin < end ? code.substr(begin, end - begin) : std::string_view();
}

// Where the value of `key` begins in a line; npos: it does not have the key.
std::size_t ValueOf(std::string_view code, std::string_view key) {
  for (std::size_t at = code.find(key); at != std::string_view::npos; at = code.find(key, at + 1)) {
    if (at > 0 && IsOfName(code[at - 1])) continue;
    const std::size_t equals = code.find_first_not_of(" \t", at + key.size());
    if (equals == std::string_view::npos || code[equals] != '=') continue;
    return code.find_first_not_of(" \t", equals + 1);
  }
  return std::string_view::npos;
}

}  // namespace

TomlNumbers::TomlNumbers(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    lines_.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return;
    text.remove_prefix(end + 1);
  }
  lines_.emplace_back();
}

std::optional<TomlNumbers::Span> TomlNumbers::Find(const Place& place) const {
  std::string_view table;
  std::string entry;  // of an [[entry]], by its name
  int before = 0;
  const std::string named = "name = \"" + std::string(place.table) + "\"";
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const std::string_view code = CodeOf(lines_[i]);
    const std::string_view begins = WithoutSpaces(code);
    if (begins.starts_with("[")) {
      table = HeaderOf(begins);
      if (begins.starts_with("[[")) entry.clear();
    }
    if (begins.starts_with("name = ")) entry = begins;
    if (table != place.table && entry != named) continue;
    if (code.find(place.beside) == std::string_view::npos) continue;
    const std::size_t at = ValueOf(code, place.key);
    if (at == std::string_view::npos || before++ != place.nth) continue;
    const std::size_t end = code.find_first_not_of(kOfNumber, at);
    return Span{i, at, std::min(end, code.size()) - at};
  }
  return std::nullopt;
}

std::optional<double> TomlNumbers::Get(const Place& place) const {
  const auto span = Find(place);
  if (!span) return std::nullopt;
  const char* begin = lines_[span->line].data() + span->begin;
  double value = 0;
  const auto [end, error] = std::from_chars(begin, begin + span->length, value);
  if (error != std::errc() || end != begin + span->length) return std::nullopt;
  return value;
}

bool TomlNumbers::Set(const Place& place, const std::string& number) {
  const auto span = Find(place);
  if (!span) return false;
  lines_[span->line].replace(span->begin, span->length, number);
  return true;
}

std::string TomlNumbers::text() const {
  std::string all;
  for (std::size_t i = 0; i < lines_.size(); ++i) all += (i == 0 ? "" : "\n") + lines_[i];
  return all;
}

}  // namespace musher::race
