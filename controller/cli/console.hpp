#pragma once
// Where a command's words go: results on one stream, complaints on the other, in colour or not, for
// people or as JSON.

#include <ostream>
#include <string>
#include <string_view>

#include "musher/controller/cli/exit_code.hpp"
#include "musher/controller/cli/options.hpp"

namespace musher::cli {

enum class Style { kPlain, kBold, kDim, kGood, kBusy, kBad };

// `text` in the style's colour; unchanged without colour.
std::string Paint(std::string_view text, Style style, bool colour);

// Whether output to a terminal (or not) is to be coloured: --color decides, then NO_COLOR and TERM.
bool WantsColour(ColourWhen when, bool terminal);

// The text as one line that does nothing to a terminal: control characters become spaces.
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

  // A line, a block of lines or a JSON document on the result stream, seen at once.
  void Print(std::string_view text);
  // False once something printed was lost, because the reader of a pipe has ended.
  bool HasReader() const { return !out_.fail(); }
  // Print() without the end of a line, for what is drawn over; on a terminal only.
  void Redraw(std::string_view text);
  // "musher: <text>" for a person, on the other stream.
  void Complain(std::string_view text);
  // A located finding or the like, as it is, on the other stream.
  void Note(std::string_view text);
  // Complains; in JSON mode the failure is the result document, too. Returns its exit code.
  ExitCode Fail(const Failure& failure);
  // Fails with ExitCode::kUsage.
  ExitCode Fail(const Error& error);

 private:
  std::ostream& out_;
  std::ostream& err_;
  Mode mode_;
};

}  // namespace musher::cli
