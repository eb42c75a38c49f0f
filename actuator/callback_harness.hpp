#pragma once
// Runs the callbacks of an actuator without a machine around it: no DDS, no threads, no time. For
// harnesses; who tests a module uses simulation/actuator_fault_test.hpp.
//
// Threads: those of the caller, one call at a time; EmergencyStop() may come beside a Run().

#include <functional>
#include <optional>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/report.hpp"

namespace musher {

class CallbackHarness {
 public:
  // Of one that is not started, and that outlives it.
  explicit CallbackHarness(MachineActuator& actuator);

  // Those that a callback is registered for; with one for whatever the config lists, the built-in
  // ones are among them.
  std::vector<State> States() const;
  // Fails where Init() and Start() would: the config does not fit the callbacks.
  Result<> Adopt(const MachineConfig& config);

  // What the callback of that state, which there must be, gives; an exception is a failure.
  Result<> Run(const State& state);
  // Fails when OnEmergencyStop() throws.
  Result<> EmergencyStop();
  void SetStopRequested(bool requested);
  // What CurrentState() and Allowed() go by; `percent` of the battery, nullopt: not known.
  void SetReport(const ActuatorReport& report);
  void SetBattery(std::optional<int> percent);
  // Called by StopRequested() before it answers, on the thread that asks; may throw out of it.
  void OnPoll(std::function<void()> on_poll);

 private:
  MachineActuator& actuator_;
};

}  // namespace musher
