#pragma once
// What the policy stores about the switches: to which state the battery has lowered the machine, in
// which state it is kept, and when a failed switch is tried again. The rules that begin switches
// are in rules/.

#include <optional>
#include <string>

#include "musher/lifecycle/step/saver.hpp"

namespace musher {

class PolicyMemory : StepPart {
 public:
  PolicyMemory(StepContext& step, Saver& saver) : StepPart(step), saver_(saver) {}

  // Restores what an earlier controller stored about the battery.
  void ResumeLowering();
  // The level, which outlives the controller.
  void SetLevel(BatteryLevel level);
  // Stores the lowering, when it has changed.
  void Lower(std::optional<BatteryFallback> lowering);
  // An actuator is lost: the battery rule brings the machine back at most to `most`.
  void LowerAtMostTo(const State& most);
  void EndKeep(const std::string& why);
  // A switch of the policy has failed, or was refused: when to try again.
  void BackOff();

  void OnSwitchEnded(const Switch& s, bool undone);
  void OnSuperseded(const Switch& s);

 private:
  Saver& saver_;
};

}  // namespace musher
