#pragma once
// Checks what controllers do to processes: they start none twice, restart none with a wrong config,
// and signal only their own that are ill.
//
// Invariants: kNoDuplicateActuator, kNoRestartOnConfigError, kOnlyOwnProcessesSignalled,
// kNoKillForTheNetwork, kTornDownBeforeSignals.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "musher/simulation/subject_checker.hpp"

namespace musher::simulation {

class ProcessChecker : public SubjectChecker {
 public:
  explicit ProcessChecker(CheckerContext& context) : SubjectChecker(context) {}

  // Before a controller starts a process.
  void OnStart(const SimulatedController& controller, const std::string& name);
  // A running process is about to exit with code 2 (configuration error).
  void OnWrongConfig(const std::string& name);
  // It may be restarted: a restart was requested, or it was killed before it exits.
  void ForgetWrongConfig(const std::string& name) { config_errors_.erase(name); }
  // Before a controller signals a process.
  void CheckSignal(const SimulatedController& controller, std::int32_t pid);
  void CheckKill(const SimulatedController& controller, std::int32_t pid);
  void NoteOverrun(const std::string& name, std::size_t host, bool begun,
                   const ActuatorReport& report);
  void CheckRunsOnce(const std::string& name);
  // Whether it was started while the link to another process of it was cut.
  bool IsDuplicated(const std::string& name) const { return duplicated_.contains(name); }

 private:
  struct RunningCallback {
    std::optional<Time> late_at;        // from then on its heartbeats report a hang
    std::optional<Time> overran_until;  // the end of the last one that they reported
  };

  void CheckRunsNowhereElse(const SimulatedController& controller, const std::string& name);
  void CheckTornDownFirst(const SimulatedController& controller, std::int32_t pid);
  void CheckProgramRunsOnce(const SimulatedController& controller, const std::string& name);
  bool IsWell(const SimulatedController& controller, const std::string& name) const;

  // The actuators that exited with a configuration error, and the controller whose child each was.
  std::map<std::string, std::uint64_t> config_errors_;
  std::set<std::string> duplicated_;  // started while the link to another process of it was cut
  std::map<std::pair<std::string, std::size_t>, RunningCallback> callbacks_;  // by actuator, host
};

}  // namespace musher::simulation
