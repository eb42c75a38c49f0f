#pragma once
// Shows a machine that is on its way to another state, for `musher set` and `musher up`: on a
// terminal a table below everything that is printed, which is redrawn from 0.5 s after the
// beginning until the end. Without a terminal, and with --json, nothing.
//
// Threads: loop thread only.

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "musher/cli/console/console.hpp"
#include "musher/cli/render/progress_table.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

class SwitchProgress {
 public:
  // The time limit of an actuator's way to a state, if it is known.
  using Limit =
      std::function<std::optional<Duration>(const std::string& actuator, const std::string& state)>;

  // The loop and the console must outlive this.
  SwitchProgress(transport::EventLoop& loop, Console& console, Limit limit);
  ~SwitchProgress() { Hide(); }
  SwitchProgress(const SwitchProgress&) = delete;
  SwitchProgress& operator=(const SwitchProgress&) = delete;

  // Whether anything is ever shown.
  bool on() const { return console_.mode().terminal && !console_.mode().json; }
  // Call at each change of the machine; none: its controller is lost.
  void Show(const std::optional<msg::MachineStatus>& machine);
  void Hide();

 private:
  struct Step {
    std::string state;   // as the table shows it
    std::string target;  // the state whose time limit applies
    Time since;
  };

  void Draw();

  transport::EventLoop& loop_;
  Console& console_;
  const Limit limit_;
  std::optional<msg::MachineStatus> machine_;  // under way
  Time begin_;                                 // of what the first line shows
  std::map<std::string, Step> steps_;          // by actuator
  bool shown_ = false;
  transport::LoopHandlePtr ticks_;  // last: its callback uses all of the above
};

}  // namespace musher::cli
