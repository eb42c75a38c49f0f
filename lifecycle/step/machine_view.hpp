#pragma once
// The queries of the parts of a step about the machine and its actuators. Reads only.

#include <cstdint>
#include <optional>

#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher {

class MachineView {
 public:
  MachineView(const MachineConfig& config, const Machine& machine)
      : config_(config), view_(machine) {}

  const KnownActuator& Of(ActuatorIndex i) const { return view_.actuators[i]; }
  const ActuatorConfig& ConfigOf(ActuatorIndex i) const { return config_.actuators[i]; }

  // Whether it is starting, though it is not present yet.
  bool IsComing(ActuatorIndex i) const;
  // Whether the controller may send it a command of its own.
  bool IsFree(ActuatorIndex i) const;
  bool MayRestart(ActuatorIndex i) const;
  // Whether the process on another host that the controller has started, or found there, follows
  // another machine now, whose controller also ends it.
  bool IsTaken(ActuatorIndex i) const;
  // The process that can be signalled: it was started by us and is not taken, or it publishes as
  // the actuator from this host. 0: none.
  std::int32_t ProcessOf(ActuatorIndex i) const;
  // The process that has to exit with the machine: this controller, or an earlier one, has started
  // it. Processes started by other parties are not ended. 0: none.
  std::int32_t OwnProcess(ActuatorIndex i) const;
  // The HostId() of the process that the controller has started: its own host, or another one whose
  // systemd runs the process.
  const std::string& HostOf(ActuatorIndex i) const;
  // Whether the process in use runs on another host than the controller starts it on. A second
  // process there would run in parallel, or waits already for the loss of the process in use.
  bool RunsElsewhere(ActuatorIndex i) const;
  // Whether the last report of the actuator is of process `pid` of HostOf(): a process of another
  // host may have the same pid.
  bool IsReportOf(ActuatorIndex i, std::int32_t pid) const;
  // Whether the report is of the last process that has exited before a status of it was received.
  // On the host of the controller no pid is proven of a process that has exited: it is 0.
  bool IsOfEnded(ActuatorIndex i, const ActuatorReport& report) const;
  // Whether a process other than `pid` of HostOf() publishes as this actuator: another party has
  // started it, or `pid` was only the program that started it.
  bool AnotherProcessIsPresent(ActuatorIndex i, std::int32_t pid) const;

  // Whether it may be in the state of the machine: it has passed its check, or is present without
  // one, in Error.
  bool Fits(ActuatorIndex i) const;
  // Whether it may be driven to the state of the machine: down always, up only after its check.
  bool MayFollow(ActuatorIndex i) const;
  // The most active state that the actuator may have while the machine is in a step of a start:
  // DeActive if the actuator lists it, else LowPower. Empty: it lists neither.
  State RestOf(ActuatorIndex i) const;
  // Whether it is more active than the machine or, in a step of a start, than RestOf().
  bool IsAbovePlace(ActuatorIndex i) const;
  // Whether a person may hold an actuator in the state until a switch of the machine.
  bool IsPlace(const State& state) const;
  // Whether it is held in a state below the machine's, or is to be held there once it is restarted.
  bool IsKeptBelow(ActuatorIndex i) const;
  // Likewise in another state that is at most as active as the machine's.
  bool IsKeptApart(ActuatorIndex i) const;
  // Its target: the state of the machine, or the one apart from it in which it is kept; while
  // suspended, DeActive or LowPower, and never higher than its present state.
  State PlaceOf(ActuatorIndex i) const;

  // Whether all actuators in the `after` of `i` are present; sets `blocker` when one will not be.
  bool NeedsMet(ActuatorIndex i, std::optional<RecordText>& blocker) const;
  // The record of the fault that blocks the actuator; 0: none.
  RecordId CauseOfBlocker(ActuatorIndex i) const;
  // The suspended actuator in its `after` that it waits for, if any.
  std::optional<RecordText> WaitsForSuspended(ActuatorIndex i) const;

  // Whether the start waits for the actuator in this stage. An actuator that an earlier controller
  // has left running is awaited in the first stage: the machine continues from its state, too.
  bool IsAwaitedIn(ActuatorIndex i, int stage) const;
  // Whether each actuator of the stages so far is present, or will not be.
  bool StageIsSetUp(int stage) const;
  // Whether each actuator of the stages so far is in the state of the machine, or will not be.
  bool StageIsSettled(int stage) const;

  // Whether a switch that is done has led the machine out of the state in which it is kept.
  bool EndsKeep(const Switch& s) const;

 protected:
  const MachineConfig& config_;
  const Machine& view_;
};

int LastStage(const MachineConfig& config);

}  // namespace musher
