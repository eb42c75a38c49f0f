#pragma once
// A switch: the legs of its plan, each begun when the legs it needs have ended; on the way up a
// rollback when one fails; a result with the outcome of every actuator.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/policy/policy_memory.hpp"
#include "musher/lifecycle/switch/commands.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/lifecycle/switch/switch_conclusion.hpp"

namespace musher {

// A switch that has ended; what follows depends on its purpose.
struct EndedSwitch {
  Purpose purpose = Purpose::kRequested;
  bool undone = false;
  bool of_machine = false;  // not of one actuator
  SwitchResult result;
  RecordId record = 0;  // of its end
};

class Switches : StepPart {
 public:
  Switches(StepContext& step, PolicyMemory& memory, Commands& commands)
      : StepPart(step), memory_(memory), commands_(commands) {}

  // Returns the number of the switch. `by`: who has requested it; empty: the controller itself.
  CommandNumber Begin(const Plan& plan, Purpose purpose, std::vector<RequestId> requests,
                      RecordId cause, const Requester& by = {});
  // `by` has requested the machine to be in the target of `s` as well.
  void NoteRequester(const Switch& s, const Requester& by);
  // Sends what can be sent.
  struct Progress {
    bool changed = false;  // other actuators may be able to proceed
    std::optional<EndedSwitch> ended = {};
  };
  Progress Advance();
  // Ends the current switch after the end of all its legs.
  EndedSwitch End();
  // Ends the current switch without rollback. Running callbacks finish; the newest command waits
  // behind them at the actuator.
  void Supersede(CommandNumber by, const State& target, RecordId cause);

  // Refuses a request for a switch that was not begun.
  void Refuse(const State& target, std::optional<ActuatorIndex> only,
              const std::vector<RequestId>& requests, const State& state, const Error& why,
              RecordId cause);
  // Ends a waiting switch without beginning it: nothing was sent for it.
  void EndWaiting(const Error& why, RecordId cause);
  // A person has requested the switch: its actuators may switch on again what a stop that is
  // released has switched off.
  void PermitSwitchingOn(const Switch& s);
  void Answer(const std::vector<RequestId>& requests, const SwitchResult& result);

 private:
  void AddLeg(Switch& s, const PlanStep& step);
  bool StartLegs(std::vector<Leg>& legs);
  std::optional<CommandResult> FindUnfit(const Leg& leg) const;
  const Leg* FindBlocker(const Leg& leg, const std::vector<Leg>& legs) const;
  void SkipLeg(Leg& leg, const Leg* blocker);
  bool StoppedOnTheLevel(const Switch& s) const;
  bool Failed(const Switch& s) const;
  void BeginRollback(Switch& s);
  State WayBack(const Leg& leg) const;
  void StandStill(const Switch& s);
  void Apply(const Switch& s, bool undone);
  static bool EndsHolds(const Switch& s);
  void Hold(const Switch& s, const Leg& leg);
  void CheckAgain();
  void DriveTheRest(const Switch& s);
  void NoteRolledBack(const Switch& s);
  void NoteHeldAfterRollback(const Switch& s, const Leg& back);
  SwitchConclusion conclusion() const { return {config_, machine_}; }

  PolicyMemory& memory_;
  Commands& commands_;
};

// "to Active", "of eyes to Active".
std::string Describe(const MachineConfig& config, const State& target,
                     std::optional<ActuatorIndex> only);

}  // namespace musher
