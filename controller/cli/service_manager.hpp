#pragma once
// What systemd is told when it runs `musher up` as a service of Type=notify: that the machine is
// usable, its state in words, that the loop still turns, and that the machine is being taken down
// or led by another. Without NOTIFY_SOCKET in the environment nothing is done at all.
//
// It is the controller process that tells, while systemd's main process is the front, its parent:
// so the unit needs NotifyAccess=all. The watchdog of the front is served from here, too; whatever
// blocks this loop lets it run out.
//
// Threads: loop thread only. Nothing waits for systemd: what it has no room for is told later, but
// for a sign of life.

#include <string>

#include "musher/controller/cli/notifier.hpp"
#include "musher/lifecycle/coordinator.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

class ServiceManager {
 public:
  // Serves the watchdog from now on, if there is one. Both must outlive it.
  ServiceManager(transport::EventLoop& loop, const MachineConfig& config);

  // READY=1 when the machine is usable, else STATUS= with why it is not.
  void StartUpEnded(const action::StartUpEnded& ended);
  // STATUS= whenever the words change, STOPPING=1 as soon as the machine is taken down.
  void Follow(const Machine& machine);
  // The machine will be taken down to be started again: that is no end of the service.
  void StartsAgain() { stopping_ = true; }
  // STOPPING=1, and STATUS= with why: another controller leads the machine.
  void Fenced(const std::string& why);

 private:
  void Status(const std::string& words);

  const MachineConfig& config_;
  Notifier notifier_;
  bool stopping_ = false;
  std::string told_;  // the last STATUS=
  transport::LoopHandlePtr watchdog_;
};

// The machine in a few words: "Active, 7 actuators", "Protected, degraded: audio", "starting,
// SelfCheck, 3 of 7 actuators".
std::string StatusWords(const MachineConfig& config, const Machine& machine);

}  // namespace musher::cli
