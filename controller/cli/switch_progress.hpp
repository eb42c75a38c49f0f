#pragma once
// Shows which actuators a switch still waits for: on a terminal one line that is redrawn, from 0.5
// s after the request until its end. Without a terminal, and with --json, nothing.
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

  // To be called before anything else is printed. The line is redrawn while the switch continues.
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
