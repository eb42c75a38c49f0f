// Reads the lines of a recording. They may be incomplete, if the recording process crashed, or
// edited by a person.

#include <algorithm>
#include <charconv>
#include <utility>

#include "musher/base/diagnostic.hpp"
#include "musher/base/suggest.hpp"
#include "musher/behavior/fsm/recording_text.hpp"
#include "musher/behavior/fsm/replay.hpp"

namespace musher::fsm {
namespace {

using Line = Recording::Line;
using Kind = Line::Kind;

struct Verb {
  std::string_view word;
  Kind kind;
  bool has_time;
  std::size_t words;  // after it, besides the time
};

constexpr Verb kVerbs[] = {
    {"start", Kind::kStart, true, 1},  {"tick", Kind::kTick, true, 0},
    {"pause", Kind::kPause, false, 0}, {"command", Kind::kCommand, false, 1},
    {"force", Kind::kForce, false, 1}, {"reset", Kind::kReset, false, 0},
    {"stop", Kind::kStop, false, 0},   {"input", Kind::kInput, false, 2},
};
constexpr std::int64_t kFarthestSeconds = kFarthestNs / 1'000'000'000;

// The words of one line. Throws Error, which ReadRecording() catches: a line is read in many steps.
class LineReader {
 public:
  LineReader(std::string_view line, const std::string& file, int number)
      : line_(line), file_(file), number_(number) {}

  bool AtEnd() const { return at_ == line_.size(); }

  std::string Word() {
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

  // As AppendTime() writes it.
  Duration Seconds() {
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

  void End() {
    begin_ = at_;
    if (!AtEnd()) Fail("there are too many words");
  }

  [[noreturn]] void Fail(const std::string& what) const {
    throw Error{
        kCodeParametersInvalid,
        FormatDiagnostic({file_, number_, static_cast<int>(begin_) + 1, Severity::kError, what})};
  }
  std::string_view rest() const { return line_.substr(at_); }

 private:
  [[noreturn]] void FailTime(const std::string& word) const {
    Fail("invalid time " + (word.empty() ? "\"\"" : word) + "; expected seconds");
  }

  char Character() {
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

  void Skip() {
    if (AtEnd()) return;
    if (line_[at_] == ' ' && at_ + 1 < line_.size()) {
      ++at_;
      return;
    }
    begin_ = at_;
    Fail("words are separated by one space");
  }

  std::string_view line_;
  const std::string& file_;
  const int number_;
  std::size_t at_ = 0;
  std::size_t begin_ = 0;  // of what is being read
};

std::string ReadHeader(LineReader& line) {
  const std::string_view format = line.rest();
  if (!format.starts_with(kRecordingFormat)) {
    line.Fail("a recording begins with \"" + std::string(kRecordingFormat) + "\" and a machine");
  }
  line.Word();
  line.Word();
  std::string machine = line.Word();
  line.End();
  return machine;
}

Line ReadLine(LineReader& reader, int number) {
  Line line;
  line.number = number;
  const std::string word = reader.Word();
  if (word == "changed") {
    line.kind = Kind::kChanged;
    line.text = reader.rest();
    while (!reader.AtEnd()) reader.Word();
    return line;
  }
  if (word == kRestored) {
    reader.Fail("from here on the machine was restored from a snapshot, which is not recorded");
  }
  const auto* const verb = std::ranges::find(kVerbs, word, &Verb::word);
  if (verb == std::end(kVerbs)) {
    std::vector<std::string_view> words{"changed"};
    for (const Verb& known : kVerbs) words.push_back(known.word);
    const std::string near = Nearest(word, words);
    reader.Fail(word + " is not a kind of line" +
                (near.empty() ? "" : "; did you mean " + near + "?"));
  }
  line.kind = verb->kind;
  if (verb->has_time) line.time = reader.Seconds();
  if (verb->words > 0) line.name = reader.Word();
  if (verb->words > 1) line.text = reader.Word();
  reader.End();
  return line;
}

}  // namespace

Result<Recording> ReadRecording(std::string_view text, const std::string& file) {
  Recording recording;
  recording.file = file;
  int number = 0;
  try {
    while (!text.empty() || number == 0) {
      ++number;
      const std::size_t end = text.find('\n');
      LineReader reader(text.substr(0, end), file, number);
      if (end == std::string_view::npos && number > 1) {
        recording.cut_short = true;
        break;
      }
      if (number == 1) {
        recording.machine = ReadHeader(reader);
      } else {
        recording.lines.push_back(ReadLine(reader, number));
      }
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
  } catch (Error& fault) {
    return std::move(fault);
  }
  return recording;
}

}  // namespace musher::fsm
