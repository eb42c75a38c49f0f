#include "musher/modules/skills/skills/recovery_skill.hpp"

#include <algorithm>
#include <chrono>
#include <string>

namespace musher::skills {
namespace {

constexpr double kMostWaitS = 1e6;

const char* DoesOf(RecoveryKind kind) {
  switch (kind) {
    case RecoveryKind::kLeaveTightStart:
      return "Leaves a place where it has no room: away from what is nearest, 0.3 m";
    case RecoveryKind::kClear:
      return "Planner and controller forget what its scanners have seen earlier";
    case RecoveryKind::kWait:
      return "Stands for a time";
    case RecoveryKind::kBackUp:
      return "Goes back 0.4 m along the path that it has come";
    case RecoveryKind::kSpin:
      return "Turns once around";
  }
  return "";
}

}  // namespace

void RecoverySkill::Declare(skill::Table& table) {
  constexpr Duration kSpare = std::chrono::seconds(2);
  table.Does(DoesOf(kind_));
  if (Recovery::Moves(kind_)) table.Uses(kBase);
  const bool waits = kind_ == RecoveryKind::kWait;
  if (waits) {
    table.Takes("duration", ToSeconds(Recovery::LongestOf(kind_)), "seconds, 0 or more");
    table.Limit({.run = skill::kNoLimit});
  }
  const auto recovering = waits ? table.State("RECOVERING")
                                : table.State("RECOVERING", Recovery::LongestOf(kind_) + kSpare);
  table.To(recovering, skill::kSucceeded, "it has ended");
  table.MonotoneProgress();
}

skill::Next RecoverySkill::Step(skill::Tick& tick) {
  const std::string name = Recovery::NameOf(kind_);
  if (Recovery::Moves(kind_) && robot_.flies()) {
    return skill::Next::Fail(robot_.name() + " flies; " + name + " is for robots on the ground");
  }
  Recovery::Amount amount;
  if (kind_ == RecoveryKind::kWait) {
    const double duration_s = tick.parameters.Number("duration");
    if (duration_s < 0) return skill::Next::Fail("Invalid duration: it is negative");
    amount.longest = FromSeconds(std::min(duration_s, kMostWaitS));
  }
  if (!begun_) recovery_.Begin(kind_, amount);
  begun_ = true;
  const auto end = recovery_.Step(tick.step);
  tick.Report(100 * recovery_.share(), "Recovers: " + name);
  if (Recovery::Moves(kind_)) {
    tick.Detail("moved_m", recovery_.moved_m());
    tick.Detail("turned_rad", recovery_.turned_rad());
  }
  if (!end) return skill::Next::Stay();
  return *end ? skill::Next::Succeed("Recovered: " + name)
              : skill::Next::Fail(name + ": " + end->error().message);
}

void RecoverySkill::OnEnd(const skill::Ended& ended) {
  if (Recovery::Moves(kind_) && !ended.paused) robot_.StopMotion();
}

void RecoverySkill::OnPause() {
  if (Recovery::Moves(kind_)) robot_.StopMotion();
}

}  // namespace musher::skills
