#pragma once
// Notifies systemd, if it runs `musher up` as a service of Type=notify: when the machine is usable,
// its state in words, the watchdog ping, and when the machine is taken down or led by another
// controller. Without NOTIFY_SOCKET in the environment it does nothing.
//
// The controller process sends the notifications, but systemd's main process is its parent, the
// launcher: the unit needs NotifyAccess=all. The launcher's watchdog is pinged from here, too;
// whatever blocks this loop lets the watchdog expire.
//
// Threads: loop thread only. Nothing waits for systemd: a message without room is sent later, a
// watchdog ping is dropped.

#include <string>

#include "musher/cli/start/notifier.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

class ServiceManager {
 public:
  // Pings the watchdog from now on, if there is one. Both must outlive it.
  ServiceManager(transport::EventLoop& loop, const MachineConfig& config);

  // READY=1 when the machine is usable, else STATUS= with why it is not.
  void StartUpEnded(const action::StartUpEnded& ended);
  // READY=1, and STATUS= with why this controller leads nothing.
  void StandsBy(const std::string& why);
  // STATUS= whenever the words change, STOPPING=1 as soon as the machine is taken down.
  void Update(const Machine& machine);
  // The machine will be taken down and restarted: the service does not stop.
  void StartsAgain() { stopping_ = true; }
  // STOPPING=1, and STATUS= with why: another controller leads the machine.
  void Fenced(const std::string& why);

 private:
  void Status(const std::string& words);

  const MachineConfig& config_;
  ServiceNotifier notifier_;
  bool stopping_ = false;
  std::string sent_status_;  // the last STATUS=
  transport::LoopHandlePtr watchdog_;
};

// The machine in a few words: "Active, 7 actuators", "Protected, degraded: audio", "starting,
// SelfCheck, 3 of 7 actuators".
std::string StatusWords(const MachineConfig& config, const Machine& machine);

}  // namespace musher::cli
