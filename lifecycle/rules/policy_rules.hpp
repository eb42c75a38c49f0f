#pragma once
// The rules that act by themselves: the battery's ceiling, LowPower when the robot lies still, and
// the TearDown before a power-off. They never supersede a switch; they are evaluated again after
// each.

#include <cstdint>
#include <string>

#include "musher/lifecycle/switch/plan.hpp"
#include "musher/lifecycle/switch/tear_down.hpp"

namespace musher {

class PolicyRules : StepPart {
 public:
  PolicyRules(StepContext& step, PolicyMemory& memory, Power& power, Switches& switches,
              TearDown& tear_down)
      : StepPart(step),
        memory_(memory),
        power_(power),
        switches_(switches),
        tear_down_(tear_down) {}

  void Begin(const event::Begin& begin);
  void On(const event::BatterySeen& seen);
  void On(const event::BatterySourceSilent& silent);
  void On(const event::MotionSeen& seen);
  void On(const event::InputSilent& silent);
  void On(const event::ClockReceived& received);
  // Returns whether something changed.
  bool Advance();

  // `wanted`, or the most that the battery allows.
  State UpTo(const State& wanted) const;

 private:
  void NoteSource(const event::BatterySeen& seen);
  void Combine();
  void EvaluateLevel(std::optional<bool> charger);
  void SetLevel(BatteryLevel level, std::optional<bool> charger);
  void CountSample();
  void Confirm();
  bool BatteryRulesWait() const;
  bool ApplyBatteryRule();
  bool TakeDown(BatteryLevel level);
  bool BringBack();
  void CountStillness();
  bool LowPowerWhenStill();
  bool BeginByPolicy(const Plan& plan, const RecordText& why, RecordId cause);
  bool TearDownForPower();

  PolicyMemory& memory_;
  Power& power_;
  Switches& switches_;
  TearDown& tear_down_;
};

}  // namespace musher
