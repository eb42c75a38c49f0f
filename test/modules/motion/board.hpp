#pragma once
// A motion board and the body on it, in memory and virtual time: takes commands as they come,
// changes to the motion after a delay and reports its progress every 20 ms. A motion in progress
// goes on. Its faults are injected from outside.

#include <algorithm>
#include <optional>
#include <vector>

#include "musher/modules/motion/motion_command.hpp"

namespace musher::motion::testing {

class Board {
 public:
  static constexpr Duration kReport = Milliseconds(20);

  void Take(const BodyCommand& command, Time now) {
    if (deaf || command.life_count == report.life_count) return;
    if (ban) {
      report.switch_status = 5;
      return;
    }
    report.life_count = command.life_count;
    const bool goes_on = command_ && command_->mode == command.mode &&
                         command_->gait == command.gait && command.duration_ms == 0;
    command_ = command;
    if (goes_on) return;
    begun_at_ = now;
    report.switch_status = 1;  // transitioning
    report.bar = 0;
  }

  BodyReport Report(Time now) {
    if (!command_ || ban) return report;
    if (now - begun_at_ < transition) return report;
    report.switch_status = command_->mode == 0 ? std::int8_t{2} : fault;
    report.mode = command_->mode;
    report.gait = command_->gait;
    const Duration ran = now - begun_at_ - transition;
    const auto percent = stuck ? 50 : std::min<std::int64_t>(100, 100 * ran / motion);
    report.bar = static_cast<std::int8_t>(percent);
    return report;
  }

  BodyReport report;                        // its report before the first command
  Duration transition = Milliseconds(100);  // from taking a command to its motion
  Duration motion = Milliseconds(400);      // that every motion takes
  std::int8_t fault = 0;                    // the status when a motion runs
  bool deaf = false;                        // takes no command
  bool ban = false;                         // refuses every transition
  bool stuck = false;                       // comes to 50 %, not further
  bool silent = false;                      // reports nothing

 private:
  std::optional<BodyCommand> command_;
  Time begun_at_{};
};

}  // namespace musher::motion::testing
