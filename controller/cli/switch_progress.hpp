#pragma once
// What a switch still waits for: on a terminal one line that is drawn over, from half a second
// after the request until its end. Elsewhere, and with --json, nothing.
//
// Threads: loop thread only.

#include <optional>
#include <string>

#include "musher/controller/cli/console.hpp"
#include "musher/controller/cli/link.hpp"

namespace musher::cli {

class SwitchProgress {
 public:
  // The link must follow the machine's status. Both it and the console must outlive this.
  SwitchProgress(Link& link, const std::string& target, Console& console);
  ~SwitchProgress() { Clear(); }
  SwitchProgress(const SwitchProgress&) = delete;
  SwitchProgress& operator=(const SwitchProgress&) = delete;

  // Before anything else is printed. It is drawn again while the switch goes on.
  void Clear();

 private:
  void Draw();

  Link& link_;
  const std::string target_;
  Console& console_;
  Time begin_;
  std::string drawn_;
  transport::LoopHandlePtr ticks_;  // last: its callback uses all of the above
};

}  // namespace musher::cli
