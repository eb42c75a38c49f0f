#pragma once
// The processes of the actuators: their termination, and the restarts by [restart].

#include <cstdint>
#include <string>

#include "musher/lifecycle/step/step_part.hpp"

namespace musher {

// How long a hung process is kept for its backtrace, and how long a process may take to exit.
inline constexpr Duration kBacktraceTime = Milliseconds(5000);
inline constexpr Duration kEndTime = Milliseconds(2000);
// A process that is torn down exits by itself; the time it gets for that.
inline constexpr Duration kExitGrace = Milliseconds(1000);
// How long the exit of a process may become known after its connection is lost. The systemd of
// another host reports an exit by ssh; the verdict that a process hangs takes 1.5 s.
inline constexpr Duration kExitIsKnown = Milliseconds(2000);

class Processes : StepPart {
 public:
  using StepPart::StepPart;

  // Process `pid` is to be killed after `grace`, unless it exits before.
  void Terminate(ActuatorIndex i, std::int32_t pid, Duration grace);
  void Kill(ActuatorIndex i);
  // The process that the controller has started runs no more.
  void ForgetProcess(ActuatorIndex i);
  // The process to be terminated has exited, or there would be no successor.
  void ForgetEnd(ActuatorIndex i);

  // The process of the actuator has exited, or could not be started: decides what follows.
  void Recover(ActuatorIndex i, const event::ProcessEnded& ended = {});
  // The actuator is present again: its restarts count until it has run for a while.
  void EvaluateArrival(ActuatorIndex i);
  void StartAgain(ActuatorIndex i);
  // Another party has started the process first.
  void CancelRestart(ActuatorIndex i);

  // Whether the exit code says that a restart does not help.
  bool IsFinal(ActuatorIndex i, const event::ProcessEnded& ended) const;
  RecordText WhyFinal(const event::ProcessEnded& ended) const;

 private:
  void GiveUp(ActuatorIndex i, const RecordText& why);
};

}  // namespace musher
