#pragma once
// A motion board as an LCM link sees it, in memory and virtual time: it knows a new command by its
// life count, does not say which one it has taken, and lies down after 500 ms without a frame. A
// frame of mode -1 is no command.

#include <optional>
#include <vector>

#include "musher/test/modules/motion/board.hpp"

namespace musher::motion::testing {

class WireBoard {
 public:
  explicit WireBoard(std::int8_t mode = 12, std::int8_t gait = 0) { Become(mode, gait); }

  void Become(std::int8_t mode, std::int8_t gait) {
    board = Board();
    board.report.mode = mode;
    board.report.gait = gait;
    board.report.bar = 100;
  }
  void Take(const BodyCommand& frame, Time now) {
    last_frame = now;
    constexpr int kHeartbeat = -1;
    if (frame.mode == kHeartbeat) return;
    if (count_ == frame.life_count) return;
    count_ = frame.life_count;
    constexpr int kLies = 7;
    if (refuses && board.report.mode == kLies && frame.mode != 0 && frame.mode != kLies &&
        frame.mode != 12) {
      board.report.switch_status = 5;  // refused
      return;
    }
    taken.push_back(frame);
    board.report.life_count = static_cast<std::int8_t>(frame.life_count + 1);  // not its own
    board.Take(frame, now);
  }
  BodyReport Report(Time now) {
    if (last_frame && now - *last_frame > Milliseconds(500)) {
      Become(7, 1);
      last_frame.reset();
      lay_down = true;
    }
    BodyReport report = board.Report(now);
    report.life_count = 0;
    return report;
  }
  // Switched off and on: it lies, and remembers nothing.
  void Restart() {
    Become(7, 0);
    count_.reset();
    taken.clear();
    last_frame.reset();
  }

  Board board;
  std::vector<BodyCommand> taken;  // each new command
  std::optional<Time> last_frame;
  bool refuses = true;    // to walk when it lies
  bool lay_down = false;  // because no frame came

 private:
  std::optional<std::int8_t> count_;
};

}  // namespace musher::motion::testing
