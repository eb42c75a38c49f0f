#include "musher/behavior/recording_line.hpp"

#include <array>
#include <charconv>

#include "musher/base/diagnostic.hpp"
#include "musher/base/result.hpp"

namespace musher {
namespace {

constexpr std::uint64_t kNsInSecond = 1'000'000'000;
constexpr std::int64_t kFarthestSeconds = kFarthestNs / 1'000'000'000;

bool IsBare(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-' || c == '.';
}

void AppendEscaped(std::string& line, char c) {
  constexpr std::string_view kHex = "0123456789abcdef";
  const auto byte = static_cast<unsigned char>(c);
  if (c == '"' || c == '\\') {
    line += '\\';
    line += c;
  } else if (c == '\n') {
    line += "\\n";
  } else if (byte < 0x20 || byte == 0x7f) {
    line += "\\x";
    line += kHex[byte >> 4];
    line += kHex[byte & 0xf];
  } else {
    line += c;
  }
}

}  // namespace

void AppendWord(std::string& line, std::string_view word) {
  if (!line.empty()) line += ' ';
  bool bare = !word.empty();
  for (const char c : word) bare = bare && IsBare(c);
  if (bare) {
    line += word;
    return;
  }
  line += '"';
  for (const char c : word) AppendEscaped(line, c);
  line += '"';
}

void AppendNumber(std::string& line, std::uint64_t number) {
  std::array<char, 20> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  line += ' ';
  line.append(digits.data(), end);
}

void AppendTime(std::string& line, Duration time) {
  const std::int64_t ns = time.count();
  const std::uint64_t size =
      ns < 0 ? -static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  AppendNumber(line, size / kNsInSecond);
  if (ns < 0) line.insert(line.find_last_of(' ') + 1, 1, '-');
  std::uint64_t rest = size % kNsInSecond;
  if (rest == 0) return;
  line += '.';
  for (std::uint64_t place = kNsInSecond / 10; rest != 0; place /= 10) {
    line += static_cast<char>('0' + rest / place);
    rest %= place;
  }
}

std::string RecordingLine::Word() {
  begin_ = at_;
  std::string word;
  if (at_ < line_.size() && line_[at_] == '"') {
    ++at_;
    while (at_ < line_.size() && line_[at_] != '"') word += Character();
    if (AtEnd()) Fail("a word has no closing quotation mark");
    ++at_;
  } else {
    while (at_ < line_.size() && line_[at_] != ' ') word += line_[at_++];
    if (word.empty()) Fail("a word is missing");
  }
  Skip();
  return word;
}

Duration RecordingLine::Seconds() {
  const std::string word = Word();
  const bool negative = word.starts_with('-');
  std::int64_t seconds = 0;
  const char* const end = word.data() + word.size();
  auto [at, wrong] = std::from_chars(word.data() + (negative ? 1 : 0), end, seconds);
  if (wrong != std::errc{} || seconds < 0 || seconds > kFarthestSeconds) FailTime(word);
  std::int64_t ns = seconds * 1'000'000'000;
  if (at != end) {
    if (*at++ != '.' || at == end) FailTime(word);
    for (std::int64_t place = 100'000'000; at != end; place /= 10, ++at) {
      if (place == 0 || *at < '0' || *at > '9') FailTime(word);
      ns += place * (*at - '0');
    }
  }
  return Duration(negative ? -ns : ns);
}

std::uint64_t RecordingLine::Number(std::uint64_t most) {
  const std::string word = Word();
  std::uint64_t number = 0;
  const char* const end = word.data() + word.size();
  const auto [at, wrong] = std::from_chars(word.data(), end, number);
  if (wrong != std::errc{} || at != end || number > most) {
    Fail("invalid number " + (word.empty() ? "\"\"" : word) + "; expected 0 to " +
         std::to_string(most));
  }
  return number;
}

void RecordingLine::End() {
  begin_ = at_;
  if (!AtEnd()) Fail("there are too many words");
}

void RecordingLine::Fail(const std::string& what) const {
  throw Error{
      kCodeParametersInvalid,
      FormatDiagnostic({file_, number_, static_cast<int>(begin_) + 1, Severity::kError, what})};
}

void RecordingLine::FailTime(const std::string& word) const {
  Fail("invalid time " + (word.empty() ? "\"\"" : word) + "; expected seconds");
}

char RecordingLine::Character() {
  const char c = line_[at_++];
  if (c != '\\') return c;
  const char kind = AtEnd() ? '\0' : line_[at_++];
  if (kind == '"' || kind == '\\') return kind;
  if (kind == 'n') return '\n';
  int code = 0;
  const char* const hex = line_.data() + at_;
  if (kind != 'x' || at_ + 2 > line_.size() ||
      std::from_chars(hex, hex + 2, code, 16).ptr != hex + 2) {
    begin_ = at_ - 2;
    Fail("a backslash stands before \", \\, n or x with two hexadecimal digits");
  }
  at_ += 2;
  return static_cast<char>(code);
}

void RecordingLine::Skip() {
  if (AtEnd()) return;
  if (line_[at_] == ' ' && at_ + 1 < line_.size()) {
    ++at_;
    return;
  }
  begin_ = at_;
  Fail("words are separated by one space");
}

}  // namespace musher
