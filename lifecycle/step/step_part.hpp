#pragma once
// One step of the decisions, and what every part of it can do: change the machine, emit actions,
// and record. The parts are small classes in the folders beside this one. The constructor of a part
// names the parts that it uses, and no two parts use each other. coordinator.cpp makes all parts.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/lifecycle/record/texts.hpp"
#include "musher/lifecycle/step/action.hpp"
#include "musher/lifecycle/step/event.hpp"
#include "musher/lifecycle/step/machine_view.hpp"

namespace musher {

// What a step reads, changes and gives.
struct StepContext {
  const MachineConfig& config;
  Machine& machine;
  Time now{};
  std::vector<Action> actions = {};
};

class StepPart : protected MachineView {
 public:
  explicit StepPart(StepContext& step)
      : MachineView(step.config, step.machine),
        machine_(step.machine),
        now_(step.now),
        actions_(step.actions) {}

 protected:
  using MachineView::Of;
  KnownActuator& Of(ActuatorIndex i) { return machine_.actuators[i]; }
  bool Critical(ActuatorIndex i) const { return ConfigOf(i).critical; }

  void Do(Action action) { actions_.push_back(std::move(action)); }

  // Each returns the id of its record. `cause`: the id of the record that it follows from, where
  // one is known. A decision with later effects stores the id for them in KnownActuator, Switch or
  // Machine.
  RecordId Record(action::Record record);
  RecordId RecordMachine(std::int32_t code, const RecordText& text, RecordId cause = 0);
  // `only`: of one actuator instead of the machine; `number` 0: the switch has not begun.
  RecordId RecordSwitch(std::optional<ActuatorIndex> only, CommandNumber number, std::int32_t code,
                        const RecordText& text, RecordId cause = 0);
  RecordId RecordBegin(const Switch& s, RecordId cause);
  RecordId RecordEnd(const Switch& s, const SwitchResult& result, RecordId cause);
  RecordId RecordActuator(ActuatorIndex i, std::int32_t code, const RecordText& text,
                          RecordId cause = 0);
  RecordId RecordProcess(ActuatorIndex i, std::int32_t code, const RecordText& text,
                         RecordId cause = 0);
  RecordId RecordPolicy(std::int32_t code, const RecordText& text, RecordId cause = 0);

  // Records the fault, once; the record becomes the cause of what follows from the fault.
  void Degrade(ActuatorIndex i, std::int32_t code, const RecordText& text, RecordId cause = 0);
  // The actuator is unavailable: the machine goes down to the actuator's on_lost, if it has one, as
  // soon as no switch is under way. Of several actuators the least active on_lost counts.
  void FallBack(ActuatorIndex i);

  // Whether a self-check that has passed as degraded is to be repeated now: of an actuator at rest,
  // which the check does not disturb.
  bool IsCheckDue(ActuatorIndex i) const;

  Time policy_now() const { return PolicyNow(config_, machine_.policy, now_); }

  Machine& machine_;
  const Time now_;

 private:
  std::vector<Action>& actions_;
};

}  // namespace musher
