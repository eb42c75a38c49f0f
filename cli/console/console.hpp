#pragma once
// The output of a command: results on one stream, errors and warnings on the other; with or without
// colour, as text or as JSON.

#include <functional>
#include <ostream>
#include <string>
#include <string_view>

#include "musher/cli/console/exit_code.hpp"
#include "musher/cli/console/options.hpp"

namespace musher::cli {

enum class Style { kPlain, kBold, kDim, kGood, kBusy, kBad };

// `text` in the style's colour; unchanged without colour.
std::string Paint(std::string_view text, Style style, bool colour);

// Whether to colour the output: --color decides, then NO_COLOR and TERM.
bool WantsColour(ColourWhen when, bool terminal);

// The text as one line that is safe for a terminal: control characters become spaces.
std::string Printable(std::string_view text);

class Console {
 public:
  struct Mode {
    bool json = false;
    bool colour = false;
    bool terminal = false;  // `out` can be redrawn
  };

  Console(std::ostream& out, std::ostream& err, Mode mode) : out_(out), err_(err), mode_(mode) {}

  const Mode& mode() const { return mode_; }

  // Prints a line, a block of lines or a JSON document to the result stream and flushes it, above
  // the block that is redrawn.
  void Print(std::string_view text);
  // False once output was lost: lost() has the reason.
  bool HasReader() const { return !out_.fail(); }
  // Why output was lost: "its reader has exited", or for example "No space left on device". "":
  // none was.
  const std::string& lost() const { return lost_; }
  // The exit code of a command that ended with `exit`: a loss of output is reported and is not
  // kDone, unless its reader has exited, as in `| head -1`, or the command has reported it.
  ExitCode AfterOutput(ExitCode exit);
  // The command has reported the loss itself, and its exit code is about something else.
  void TakeLost() { taken_ = true; }
  // Print() without a newline, for a line that is redrawn; on a terminal only.
  void Redraw(std::string_view text);
  // Lines below everything that is printed, until HideBlock() or another block replaces them; a
  // line that is too long for the terminal is cut. On a terminal only.
  void ShowBlock(std::string lines);
  void HideBlock() { ShowBlock(""); }
  // Prints "musher: <text>" to the error stream.
  void PrintError(std::string_view text);
  // Prints the text unchanged to the error stream, for example a diagnostic.
  void Note(std::string_view text);
  // Prints the error; in JSON mode the failure is the result document, too. Returns its exit code.
  ExitCode Fail(const Failure& failure);
  // Fails with ExitCode::kUsage.
  ExitCode Fail(const Error& error);

 private:
  void EraseBlock();
  void DrawBlock();
  void Write(const std::function<void()>& write);

  std::ostream& out_;
  std::ostream& err_;
  Mode mode_;
  std::string block_;  // without a newline at its end; empty: none
  std::string lost_;
  bool quiet_ = false;  // the reader has exited
  bool taken_ = false;
};

}  // namespace musher::cli
