#include "musher/cli/console/terminal_screen.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>

namespace musher::cli {

TerminalScreen::TerminalScreen(Console& console) : console_(console) {
  termios settings{};
  if (isatty(STDIN_FILENO) == 1 && tcgetattr(STDIN_FILENO, &settings) == 0) {
    before_ = settings;
    settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    settings.c_cc[VMIN] = 0;  // read() returns at once
    settings.c_cc[VTIME] = 0;
    settings.c_cc[VSUSP] = _POSIX_VDISABLE;
    tcsetattr(STDIN_FILENO, TCSANOW, &settings);
  }
  console_.Redraw("\x1b[?1049h\x1b[?25l\x1b[?7l");
}

TerminalScreen::~TerminalScreen() {
  console_.Redraw("\x1b[?7h\x1b[?25h\x1b[?1049l");
  if (before_) tcsetattr(STDIN_FILENO, TCSAFLUSH, &*before_);
}

char TerminalScreen::NextKey() {
  char key = 0;
  ssize_t got = 0;
  do {
    got = read(STDIN_FILENO, &key, 1);
  } while (got < 0 && errno == EINTR);
  return got == 1 ? key : '\0';
}

TerminalScreen::Size TerminalScreen::SizeNow() {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) {
    return {};
  }
  return {size.ws_col, size.ws_row};
}

}  // namespace musher::cli
