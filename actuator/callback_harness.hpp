#pragma once
// Runs the callbacks of an actuator without a machine: no DDS, no threads, no time. For test
// harnesses; to test a module use simulation/actuator_fault_test.hpp.
//
// Threads: the caller's, one call at a time; EmergencyStop() may run beside a Run().

#include <functional>
#include <optional>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/report.hpp"

namespace musher {

class CallbackHarness {
 public:
  // The actuator must not be started and must outlive the harness.
  explicit CallbackHarness(MachineActuator& actuator);

  // The states with a registered callback; with a callback for all listed states, the built-in ones
  // are included.
  std::vector<State> States() const;
  // Fails like Init() and Start() if the config does not fit the callbacks.
  Result<> Adopt(const MachineConfig& config);

  // Sets what node() returns until Shutdown(). Default: null.
  void SetNode(std::shared_ptr<transport::NodeThread> node);

  // Returns the result of that state's callback, which must exist; an exception is a failure.
  Result<> Run(const State& state);
  // Fails if OnEmergencyStop() throws.
  Result<> EmergencyStop();
  void SetStopRequested(bool requested);
  // Input of CurrentState() and Allowed(); `percent` of the battery, nullopt: unknown.
  void SetReport(const ActuatorReport& report);
  void SetBattery(std::optional<int> percent);
  // StopRequested() calls it first, on the calling thread; exceptions pass through StopRequested().
  void OnPoll(std::function<void()> on_poll);

 private:
  MachineActuator& actuator_;
};

}  // namespace musher
