#pragma once
// Starts, finds, watches and signals the processes of the actuators, and saves what the next
// controller needs to find them again.
//
// Threads: loop thread only.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "musher/controller/shell/actuator_peers.hpp"
#include "musher/controller/shell/controller_presence.hpp"
#include "musher/controller/shell/health_watch.hpp"
#include "musher/controller/shell/shell_context.hpp"

namespace musher {

// Whether a signal that has waited for the connection to its host still has its reason. A silence
// that may yet end is none for the SIGKILL of a reason that has passed.
bool IsStillEnded(const Machine& machine, ActuatorIndex actuator, pid_t pid);

class ActuatorProcesses {
 public:
  // All must outlive it.
  ActuatorProcesses(ShellContext context, ControllerPresence& presence, HealthWatch& health,
                    ActuatorPeers& peers);

  // Watches the processes in `begin`, and clears those that do not run any more. `children`: those
  // that an earlier controller has started.
  void TakeOver(event::Begin& begin, const std::vector<ChildProcess>& children);

  // Connects to the hosts that run processes as units, once the machine has begun.
  void OpenHosts();

  // What the kernel reports of each process of this host that has not announced its actuator by its
  // deadline; for the decision, before it gives them up.
  std::vector<event::StartExamined> OverdueStarts(const Machine& machine, Time now) const;

  void Do(const action::StartProcess& a);
  void Do(const action::FindProcesses& a);
  void Do(const action::SignalProcess& a);
  void Do(const action::TakeBacktrace& a);
  // The command survives this controller, which is about to exit.
  void Do(const action::RunPowerCommand& a);
  // Forgets the starts that wait, and the other hosts: another controller leads, or the machine is
  // stopped.
  void CancelStarts();

 private:
  // Whether the command of the actuator runs on another host, by the config.
  bool IsOnHost(ActuatorIndex actuator) const;
  // Whether the process that the controller has started for the actuator runs on another host.
  bool RunsOnHost(ActuatorIndex actuator) const;
  bool IsOfOther(ActuatorIndex actuator, pid_t pid) const;
  // Whether the command of the actuator runs as a unit of this host.
  bool IsOwnUnit(ActuatorIndex actuator) const;
  HostProcesses::Hooks HookHosts();
  void OwnUnitStarted(ActuatorIndex actuator, pid_t pid, bool found);
  void AwaitOwnEnd(ActuatorIndex actuator, pid_t pid);
  void OwnUnitEnded(ActuatorIndex actuator, pid_t pid, const ProcessExit& exit);
  void EndOwnUnit(ActuatorIndex actuator, pid_t pid);
  void ReportEnd(ActuatorIndex actuator, pid_t pid, const ProcessExit& exit);
  void Ended(ActuatorIndex actuator, pid_t pid, const ProcessExit& exit);
  // Finds the processes of this host, and watches them from then on.
  event::ProcessesFound FindHere();
  ProcessSpec SpecOf(ActuatorIndex actuator) const;
  bool WatchFound(ActuatorIndex actuator, pid_t pid, const ChildProcess* child);
  void NoteChild(ActuatorIndex actuator, pid_t pid);
  void ForgetChild(ActuatorIndex actuator, pid_t pid);
  void SaveChildren();

  const ShellContext context_;
  const ShellDependencies& dependencies_;
  const MachineConfig& config_;
  ControllerPresence& presence_;
  HealthWatch& health_;
  ActuatorPeers& peers_;
  std::map<ActuatorIndex, ChildProcess> children_;  // the running ones
  bool children_unsaved_ = false;                   // the last save failed, which was reported
  bool power_command_runs_ = false;                 // the command of power-off or reboot
  std::map<ActuatorIndex, transport::LoopHandlePtr> starts_later_;
  struct OwnUnit {
    ProcessLog log = {};                         // where this controller has started it
    pid_t unwatched = 0;                         // whose exit the kernel does not report
    pid_t exited = 0;                            // whose exit the kernel has reported
    pid_t ended = 0;                             // whose end systemd has reported
    ProcessExit how = {};                        // that end
    transport::LoopHandlePtr silence = nullptr;  // ends the wait for that
  };
  std::map<ActuatorIndex, OwnUnit> own_units_;
};

}  // namespace musher
