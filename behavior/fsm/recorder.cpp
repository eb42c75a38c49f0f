#include "musher/behavior/fsm/recorder.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/behavior/fsm/recording_text.hpp"

namespace musher::fsm {
namespace {

constexpr std::uint64_t kNsInSecond = 1'000'000'000;

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

void AppendChange(std::string& line, const Machine& machine, const Change& change) {
  AppendNumber(line, change.tick);
  AppendTime(line, change.at);
  AppendWord(line, machine.Name(change.from));
  AppendWord(line, machine.Name(change.to));
  AppendWord(line, Name(change.cause));
  if (change.command != kNoEvent) AppendWord(line, machine.Name(change.command));
}

Recorder::Recorder(Machine& machine, Sink sink) : machine_(machine), sink_(std::move(sink)) {
  MUSHER_CHECK(sink_ && !machine.running());
  line_ = kRecordingFormat;
  AppendWord(line_, machine.name());
  Write();
  machine_.Listen(this);
}

Recorder::~Recorder() {
  machine_.Forget(this);
}

void Recorder::Input(std::string_view name, std::string_view text) {
  line_ = "input";
  AppendWord(line_, name);
  AppendWord(line_, text);
  Write();
}

void Recorder::OnInput(const Machine& machine, const fsm::Input& input) {
  using Kind = fsm::Input::Kind;
  constexpr std::array<std::string_view, 7> kWords{"start", "tick",  "pause", "command",
                                                   "force", "reset", "stop"};
  // A restore is not notified. It shows here: a machine that does not run gets no input but a
  // start.
  if (input.kind != Kind::kStart && !running_) {
    line_ = kRestored;
    Write();
  }
  running_ = true;
  line_ = kWords[static_cast<std::size_t>(input.kind)];
  if (input.kind == Kind::kStart || input.kind == Kind::kTick) {
    if (!first_start_) first_start_ = input.time;
    AppendTime(line_, input.time - *first_start_);
  }
  if (input.kind == Kind::kCommand) AppendWord(line_, machine.Name(input.command));
  if (input.state != kNoState) AppendWord(line_, machine.Name(input.state));
  Write();
}

void Recorder::OnChange(const Machine& machine, const Change& change) {
  running_ = change.to != kNoState;
  line_ = "changed";
  AppendChange(line_, machine, change);
  Write();
}

void Recorder::Write() {
  line_ += '\n';
  sink_(line_);
}

}  // namespace musher::fsm
