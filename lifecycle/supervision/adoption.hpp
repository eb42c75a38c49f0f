#pragma once
// A starting controller finds running actuators: the state from which the machine continues, and
// whether the previous controller crashed during a switch. Reads only.

#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/step/machine_view.hpp"

namespace musher {

class Adoption : MachineView {
 public:
  using MachineView::MachineView;

  // The least active state that the running actuators are in, or are switching to. Of several
  // states with the same rank, the state of most actuators wins; only actuators that list all of
  // these states count.
  std::optional<State> LowestFound() const;
  // Whether the previous controller crashed while it tore the machine down.
  bool FoundTearDown() const;
  // Whether the machine may have stood in SelfCheck, to which a person had switched it, perhaps
  // with an actuator that was restarted meanwhile. A start that the previous controller has not
  // ended looks the same.
  bool FoundInSelfCheck() const;
  // Whether the previous controller crashed during a switch.
  bool FoundSwitching() const;
  // The actuators that are in another state than the machine, or switching.
  std::string Elsewhere() const;

 private:
  struct Found {
    ActuatorIndex actuator = 0;
    State state;
  };
  State Lowest(const std::vector<Found>& found) const;
  bool AgreesWith(ActuatorIndex i, const State& state) const;
};

}  // namespace musher
