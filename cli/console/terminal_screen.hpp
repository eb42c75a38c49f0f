#pragma once
// The whole terminal for a live view: another screen without a cursor and
// without line wrap, keys without echo. The
// destructor restores everything.
//
// Threads: one.

#include <termios.h>

#include <cstddef>
#include <optional>

#include "musher/cli/console/console.hpp"

namespace musher::cli {

class TerminalScreen {
 public:
  // Ctrl-Z is switched off: it would leave the screen as it is.
  explicit TerminalScreen(Console& console);
  ~TerminalScreen();
  TerminalScreen(const TerminalScreen&) = delete;
  TerminalScreen& operator=(const TerminalScreen&) = delete;

  bool HasKeys() const { return before_.has_value(); }  // stdin is a terminal, too
  // The next key that was pressed; 0: none, or stdin has ended.
  static char NextKey();

  struct Size {
    std::size_t columns = 80;
    std::size_t lines = 24;
  };
  static Size SizeNow();

 private:
  Console& console_;
  std::optional<termios> before_;
};

}  // namespace musher::cli
