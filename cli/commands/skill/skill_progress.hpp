#pragma once
// Shows how far a skill is: on a terminal one line with a bar, redrawn at each report and each
// second; else a line for each change; with --json nothing.
//
// Threads: loop thread only.

#include <string>

#include "musher/cli/console/console.hpp"
#include "musher/cli/machine/skill_choice.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

class SkillProgress {
 public:
  // The loop and the console must outlive this.
  SkillProgress(transport::EventLoop& loop, const std::string& skill, Console& console);
  ~SkillProgress() { Clear(); }
  SkillProgress(const SkillProgress&) = delete;
  SkillProgress& operator=(const SkillProgress&) = delete;

  void Show(const SkillReport& report);
  // Call before anything else is printed.
  void Clear();
  // Since the construction.
  Duration elapsed() const { return loop_.Now() - begin_; }

 private:
  void Draw();

  transport::EventLoop& loop_;
  const std::string skill_;
  Console& console_;
  const Time begin_;
  SkillReport report_;
  bool drawn_ = false;
  transport::LoopHandlePtr ticks_;  // last: its callback uses all of the above
};

}  // namespace musher::cli
