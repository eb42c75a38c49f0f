#pragma once
// A robot for tests of the tree: each goal takes its time and ends as the test decides. Its body is
// at the target of a drive that has succeeded. Simulated time only.

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "musher/modules/meilin/nodes/goal_watch.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin::testing {

enum class Kind { kMove, kSuspension, kArm, kSpear };

// How a goal ends, and when. kAccepted: never.
struct Outcome {
  GoalState end = GoalState::kSucceeded;
  std::string message{};
  Duration after = Milliseconds(50);
};

struct FakeGoal {
  Kind kind = Kind::kMove;
  std::string server;
  MoveGoal move{};
  SuspensionGoal suspension{};
  ArmGoal arm{};
  SpearGoal spear{};
  Time begun{};
  Outcome outcome{};
  GoalState state = GoalState::kAccepted;
  bool cancelled = false;
  std::string message;
  std::string feedback;

  // "move 1.20 2.40 90", "suspension up forward 200", "arm 1", "spear 3"
  std::string Text() const;
};

class FakeRobot final : public Robot {
 public:
  // What a test sets.
  std::function<Outcome(const FakeGoal&)> decide = [](const FakeGoal&) { return Outcome{}; };
  std::optional<PoseFix> fix;
  bool follows = true;  // the pose follows the drives, and is always fresh
  double z_m = std::numeric_limits<double>::quiet_NaN();  // of the body after a drive
  std::optional<Wheels> legs;  // always fresh; follow the suspension where they are set
  bool legs_follow = true;
  int sequence = 0;  // state of the suspension
  Signal r1;
  bool r1_stays = false;  // else it is false at the end of the dock's command
  Signal arm;
  bool arm_reports = true;  // it repeats its last report
  // What it sees.
  std::vector<std::shared_ptr<FakeGoal>> goals;
  std::vector<std::string> warnings;

  void Advance(Duration step);
  Time Now() const { return now_; }
  std::size_t Running() const;
  std::vector<std::string> Texts() const;
  static void Raise(Signal& signal, bool value);

  GoalPtr MoveToPose(const std::string& server, const MoveGoal& goal) override;
  GoalPtr ControlSuspension(const std::string& server, const SuspensionGoal& goal) override;
  GoalPtr MoveArm(const std::string& server, const ArmGoal& goal) override;
  GoalPtr MoveSpear(const std::string& server, const SpearGoal& goal) override;
  std::optional<PoseFix> pose() const override { return fix; }
  std::optional<Wheels> wheels() const override { return legs; }
  int suspension_state() const override { return sequence; }
  const Signal& partner_ready() const override { return r1; }
  const Signal& arm_idle() const override { return arm; }
  void Warn(const std::string& text) override { warnings.push_back(text); }

 private:
  GoalPtr Begin(FakeGoal goal);
  void End(FakeGoal& goal);

  Time now_{Milliseconds(1000)};
};

}  // namespace musher::meilin::testing
