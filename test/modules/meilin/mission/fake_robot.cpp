#include "musher/test/modules/meilin/mission/fake_robot.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include <fmt/format.h>

namespace musher::meilin::testing {
namespace {

class Handle final : public Goal {
 public:
  explicit Handle(std::shared_ptr<FakeGoal> goal) : goal_(std::move(goal)) {}
  GoalState state() const override { return goal_->state; }
  const std::string& message() const override { return goal_->message; }
  int final_state() const override { return 7; }
  const std::string& feedback() const override { return goal_->feedback; }
  void Cancel() override {
    if (HasEnded(goal_->state)) return;
    goal_->cancelled = true;
    goal_->state = GoalState::kCancelled;
  }

 private:
  const std::shared_ptr<FakeGoal> goal_;
};

}  // namespace

std::string FakeGoal::Text() const {
  constexpr std::array<const char*, 4> kModes = {"auto", "up", "down", "direct"};
  switch (kind) {
    case Kind::kMove:
      return fmt::format("move {:.2f} {:.2f} {:.0f}", move.x_m, move.y_m,
                         move.yaw_rad * 180 / std::numbers::pi);
    case Kind::kSuspension:
      return fmt::format("suspension {} {} {:g}", kModes.at(suspension.mode), suspension.direction,
                         suspension.height_mm);
    case Kind::kArm:
      return fmt::format("arm {}", arm.command);
    case Kind::kSpear:
      return fmt::format("spear {}", spear.command);
  }
  return "";
}

GoalPtr FakeRobot::Begin(FakeGoal goal) {
  goal.begun = now_;
  goal.outcome = decide(goal);
  const bool at_once =
      goal.outcome.end == GoalState::kUnavailable || goal.outcome.end == GoalState::kRejected;
  if (at_once) goal.outcome.after = Duration{};
  goals.push_back(std::make_shared<FakeGoal>(std::move(goal)));
  if (at_once) End(*goals.back());
  return std::make_unique<Handle>(goals.back());
}

void FakeRobot::End(FakeGoal& goal) {
  goal.state = goal.outcome.end;
  goal.message = goal.outcome.message;
  if (goal.state != GoalState::kSucceeded) return;
  if (goal.kind == Kind::kMove) fix = {goal.move.x_m, goal.move.y_m, goal.move.yaw_rad, now_, z_m};
  if (goal.kind == Kind::kSuspension && legs && legs_follow) {
    legs->mm.fill(goal.suspension.mode == 3 ? goal.suspension.height_mm : 20);
  }
  if (goal.kind == Kind::kArm) Raise(arm, true);
  if (goal.kind == Kind::kSpear && goal.spear.command == 3 && !r1_stays) {
    Raise(r1, false);
  }
}

void FakeRobot::Raise(Signal& signal, bool value) {
  if (value) ++signal.trues;
  if (value && signal.value != true) ++signal.rises;
  signal.value = value;
}

void FakeRobot::Advance(Duration step) {
  now_ += step;
  if (follows && fix) fix->at = now_;
  if (legs) legs->at = now_;
  if (arm_reports) arm.at = now_;
  for (const auto& goal : goals) {
    if (HasEnded(goal->state) || !HasEnded(goal->outcome.end)) continue;
    if (now_ - goal->begun >= goal->outcome.after) End(*goal);
  }
}

std::size_t FakeRobot::Running() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(goals, [](const auto& goal) { return !HasEnded(goal->state); }));
}

std::vector<std::string> FakeRobot::Texts() const {
  std::vector<std::string> texts;
  for (const auto& goal : goals) texts.push_back(goal->Text());
  return texts;
}

GoalPtr FakeRobot::MoveToPose(const std::string& server, const MoveGoal& goal) {
  FakeGoal fake;
  fake.kind = Kind::kMove;
  fake.server = server;
  fake.move = goal;
  return Begin(fake);
}
GoalPtr FakeRobot::ControlSuspension(const std::string& server, const SuspensionGoal& goal) {
  FakeGoal fake;
  fake.kind = Kind::kSuspension;
  fake.server = server;
  fake.suspension = goal;
  return Begin(fake);
}
GoalPtr FakeRobot::MoveArm(const std::string& server, const ArmGoal& goal) {
  FakeGoal fake;
  fake.kind = Kind::kArm;
  fake.server = server;
  fake.arm = goal;
  return Begin(fake);
}
GoalPtr FakeRobot::MoveSpear(const std::string& server, const SpearGoal& goal) {
  FakeGoal fake;
  fake.kind = Kind::kSpear;
  fake.server = server;
  fake.spear = goal;
  return Begin(fake);
}

}  // namespace musher::meilin::testing
