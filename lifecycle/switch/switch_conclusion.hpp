#pragma once
// What a switch has come to: its outcome, the outcome of each actuator, and the reason. Reads only.

#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/step/machine_view.hpp"

namespace musher {

class SwitchConclusion : MachineView {
 public:
  using MachineView::MachineView;

  // `undone`: the machine is in its state from before the switch.
  SwitchResult Conclude(const Switch& s, bool undone) const;
  // The leg whose outcome decides the switch; null when none has failed.
  const Leg* WorstLeg(const Switch& s) const;

 private:
  std::vector<ActuatorResult> Results(const Switch& s) const;
  void CorrectIfAway(const Switch& s, ActuatorIndex i, ActuatorResult& result) const;
  static const Leg* FirstPartial(const Switch& s);
  std::optional<Error> WhyAway(const Switch& s, ActuatorIndex i) const;
  std::optional<Error> SecondAbove(const Switch& s, ActuatorIndex i) const;
  std::optional<ActuatorIndex> FirstAway(const Switch& s) const;
  bool IsAway(ActuatorIndex i, const State& target) const;
  std::string LeftSince(const Switch& s, ActuatorIndex i) const;
};

}  // namespace musher
