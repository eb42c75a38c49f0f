#pragma once
// What the end of a unit means: its program ended by itself, or with its host.
//
// At an orderly shutdown of a host its systemd ends all units by SIGTERM. A program that handles
// SIGTERM exits with code 0, as if its work were done. Yet the process has to be started again once
// the host is back.
//
// Threads: any.

#include <string_view>

#include "musher/controller/process/process_runner.hpp"

namespace musher {

// SystemState of a systemd that shuts its host down, from the request on: before it ends a unit.
inline constexpr std::string_view kSystemStops = "stopping";

// Whether EndOfUnit() needs the state of the host's systemd. `signalled`: the machine has ended the
// process; then its host does not matter. In a TearDown of the machine it does: exit code 0 would
// count as the end of the actuator's own TearDown.
inline bool NeedsSystemState(const ProcessExit& exit, bool signalled) {
  return !signalled &&
         (exit.kind == ProcessExit::Kind::kExited || exit.kind == ProcessExit::Kind::kUnknown);
}

// `system_state`: that of the host's systemd after the end; empty: unknown. `rebooted`: the host
// has another boot id than when the process ran.
inline ProcessExit EndOfUnit(const ProcessExit& exit, std::string_view system_state,
                             bool rebooted) {
  if (!rebooted && system_state != kSystemStops) return exit;
  return {ProcessExit::Kind::kHostWentDown};
}

}  // namespace musher
