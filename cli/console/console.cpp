#include "musher/cli/console/console.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "musher/cli/console/error_json.hpp"

namespace musher::cli {
namespace {

const char* EscapeOf(Style style) {
  switch (style) {
    case Style::kBold:
      return "\x1b[1m";
    case Style::kDim:
      return "\x1b[2m";
    case Style::kGood:
      return "\x1b[32m";
    case Style::kBusy:
      return "\x1b[33m";
    case Style::kBad:
      return "\x1b[31m";
    case Style::kPlain:
      break;
  }
  return "";
}

std::string_view Variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr ? value : "";
}

}  // namespace

std::string Paint(std::string_view text, Style style, bool colour) {
  if (!colour || style == Style::kPlain || text.empty()) return std::string(text);
  return EscapeOf(style) + std::string(text) + "\x1b[0m";
}

bool WantsColour(ColourWhen when, bool terminal) {
  if (when != ColourWhen::kAuto) return when == ColourWhen::kAlways;
  return terminal && Variable("NO_COLOR").empty() && Variable("TERM") != "dumb";
}

std::string Printable(std::string_view text) {
  std::string printable(text);
  std::replace_if(
      printable.begin(), printable.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
  // U+0080 to U+009F, some of which begin a control sequence as ESC [ does.
  for (std::size_t i = 0; i + 1 < printable.size(); ++i) {
    const auto next = static_cast<unsigned char>(printable[i + 1]);
    if (printable[i] == '\xc2' && next >= 0x80 && next < 0xa0) printable.replace(i, 2, "  ");
  }
  return printable;
}

// Writes and flushes. The first write that fails has the reason in `errno`: it may be the one of a
// full buffer, before the flush.
void Console::Write(const std::function<void()>& write) {
  const bool failed_before = out_.fail();
  errno = 0;
  write();
  out_.flush();
  if (failed_before || !out_.fail()) return;
  const int reason = errno;
  quiet_ = reason == EPIPE;
  lost_ = quiet_ ? "its reader has exited" : std::generic_category().message(reason);
}

void Console::Print(std::string_view text) {
  Write([&] {
    EraseBlock();
    out_ << text;
    if (!text.empty() && text.back() != '\n') out_ << '\n';
    DrawBlock();
  });
}

void Console::ShowBlock(std::string lines) {
  if (!mode_.terminal) return;
  while (lines.ends_with('\n')) lines.pop_back();
  if (lines == block_) return;
  Write([&] {
    EraseBlock();
    block_ = std::move(lines);
    DrawBlock();
  });
}

// The cursor is at the end of the block's last line.
void Console::EraseBlock() {
  if (block_.empty()) return;
  out_ << "\r\x1b[K";
  for (const char c : block_) {
    if (c == '\n') out_ << "\x1b[A\x1b[K";
  }
}

// Without line wrap, so that a line of the block is one of the terminal.
void Console::DrawBlock() {
  if (!block_.empty()) out_ << "\x1b[?7l" << block_ << "\x1b[?7h";
}

void Console::Redraw(std::string_view text) {
  Write([&] { out_ << text; });
}

void Console::Note(std::string_view text) {
  Write([&] { EraseBlock(); });
  err_ << Printable(text) << '\n';
  err_.flush();
  Write([&] { DrawBlock(); });
}

void Console::PrintError(std::string_view text) {
  Note("musher: " + std::string(text));
}

ExitCode Console::Fail(const Failure& failure) {
  if (mode_.json) Print(FailureJson(failure));
  PrintError(failure.error.message);
  return failure.exit;
}

ExitCode Console::Fail(const Error& error) {
  return Fail(Failure{ExitCode::kUsage, error});
}

ExitCode Console::AfterOutput(ExitCode exit) {
  if (lost_.empty() || quiet_ || taken_) return exit;
  PrintError("output lost: " + lost_);
  return exit == ExitCode::kDone ? ExitCode::kUsage : exit;
}

}  // namespace musher::cli
