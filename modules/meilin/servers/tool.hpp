#pragma once
// A tool that carries out numbered commands and reports when it is done: the arm and the spear.
// Pure: reports and the time are arguments.
//
//   idle ──Begin()──▶ runs ──▶ done, at its time limit, or Stop()
//
// - A done counts when it is new: where the report before the command was a done, or there was
//   none, one that is not a done must come first. The hardware repeats its last report.
// - Command 0 (IDLE) stops the tool; it is done at once.
// - At each end but done, command 0 is sent. The hardware may report a done of it, or a late one of
//   the command that it ends: the next command is sent after such a done, which is new as well, or
//   kSettle later.
// - AwaitIdle() is the same for a command of a process before this one: command 0 is sent. The tool
//   is neither idle nor well before it has settled.
//
// Seconds. One thread.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::meilin::servers {

// What a command is called, how long it usually takes, and the state meanwhile.
struct ToolCommand {
  std::string name;
  double expected_s = 1;
  std::int32_t state = 0;
};

struct ToolKind {
  std::string name;                   // "Arm"
  std::vector<ToolCommand> commands;  // by their number
};
// The commands of the actions ArmAction and SpearAction.
const ToolKind& ArmKind();
const ToolKind& SpearKind();

inline constexpr std::int32_t kToolDone = 10;
inline constexpr std::int32_t kToolError = -1;

class Tool {
 public:
  static constexpr Duration kSettle = Milliseconds(1000);

  // `time_limit`: of a goal without one.
  Tool(const ToolKind& kind, Duration time_limit) : kind_(kind), time_limit_(time_limit) {}

  // The report of the hardware: 1 is done.
  void OnReport(double done);
  // The world was restarted, and its hardware with it.
  void Forget();
  // Command 0 was sent before the first command.
  void AwaitIdle(Time now);

  // Begins a command of the kind; a limit of 0 and less: the tool's own. It is sent by TakeDue().
  void Begin(std::uint8_t command, double limit_s, Time now);
  // Whether the command is to be sent now: true once for each Begin().
  bool TakeDue(Time now);
  void Stop(Time now);

  struct End {
    bool success = false;
    std::string message;
  };
  std::optional<End> Update(Time now);

  bool running() const { return running_; }
  // Nothing runs, and the last run was done; or there was none, and it has settled.
  bool IsIdleAndWell(Time now) const;
  // 0 idle; of the running command; 10 done; -1 error.
  std::int32_t state() const { return state_; }
  // 0 to 1, by the expected time; 1 when it is done.
  double Progress(Time now) const;
  double ElapsedSeconds(Time now) const;
  const ToolKind& kind() const { return kind_; }
  std::uint8_t command() const { return command_; }

 private:
  bool Settles(Time now) const;

  const ToolKind& kind_;
  const Duration time_limit_;
  std::uint8_t command_ = 0;
  bool running_ = false;
  bool sent_ = false;
  bool has_begun_ = false;
  bool well_ = false;
  bool done_ = true;    // the last report; before the first one an old done may be repeated
  bool armed_ = false;  // a done counts
  bool fresh_done_ = false;
  std::int32_t state_ = 0;
  Time begun_;
  Time sent_at_;
  std::optional<Time> stopped_at_;
  bool stop_armed_ = false;  // since then: a done counts
  bool stop_done_ = false;   // and was reported
  Duration limit_{};
};

}  // namespace musher::meilin::servers
