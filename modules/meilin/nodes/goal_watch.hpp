#pragma once
// One goal of a node: its time limit, and the text of its failure.
//
//   watch_.Begin(robot.MoveToPose("move_to_pose", goal), {.what = "target_align", ...}, now);
//   in each tick:   watch_.Look(now)   until it is not kRunning
//   on a halt:      watch_.Cancel()
//
// Texts of failures begin with
//   <client> action server not available
//   Goal rejected by <server>
//   <what> timed out
//   <what> lost its server
//   <server>: <its own message> after <n> s (<what>, of at most <limit> s; <the last feedback>)
// Times: seconds of the tree's clock; a limit that is not positive
// is none. Threads: one at a time, like the tree.

#include <string>
#include <utility>

#include "musher/base/time.hpp"
#include "musher/behavior/tree/status.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin {

// The names of the actions.
inline constexpr const char* kMoveServer = "move_to_pose";
inline constexpr const char* kSuspensionServer = "suspension_control";
inline constexpr const char* kArmServer = "arm_action";
inline constexpr const char* kSpearServer = "spear_action";

class GoalWatch {
 public:
  struct Names {
    std::string what;    // "target_align": the step of the node
    std::string client;  // "ArmAction": in "... action server not available"
    std::string server;  // "arm_action"
  };

  // Cancels the goal before.
  void Begin(GoalPtr goal, Names names, double limit_s, Time now);
  // IDLE: no goal was begun. A goal that has failed is cancelled; then failure() says why.
  tree::Status Look(Time now);
  // Whether the server has accepted it, now or earlier.
  bool accepted() const;
  bool running() const { return status_ == tree::Status::kRunning; }
  bool succeeded() const { return status_ == tree::Status::kSuccess; }
  void Cancel();
  // Forgets the goal, which goes on.
  void Release();
  const std::string& failure() const { return failure_; }
  const Goal* goal() const { return goal_.get(); }

 private:
  std::string FailureText(double spent_s) const;

  GoalPtr goal_;
  Names names_;
  double limit_s_ = 0;
  Time begun_{};
  tree::Status status_ = tree::Status::kIdle;
  std::string failure_;
};

// "Motion_control_accurate /move_to_pose", as texts name that client.
std::string MoveClientName(const std::string& server);

}  // namespace musher::meilin
