#include "musher/simulation/phase.hpp"

#include <algorithm>
#include <array>

namespace musher::simulation {
namespace {

constexpr std::array<std::string_view, kMachinePhases> kNames = {
    "no leader", "setting up",   "at rest",      "joining", "sent",         "partly done",
    "overdue",   "rolling back", "falling back", "stopped", "tearing down", "over"};

MachinePhase MachinePhaseOfSwitch(const Switch& s, const Machine& machine) {
  if (s.rollback.under_way) return MachinePhase::kRollingBack;
  if (s.purpose == Purpose::kStop) return MachinePhase::kTearingDown;
  const bool overdue =
      std::any_of(machine.actuators.begin(), machine.actuators.end(),
                  [](const KnownActuator& r) { return r.command && r.command->queries > 0; });
  if (overdue) return MachinePhase::kOverdue;
  if (s.purpose == Purpose::kFallback) return MachinePhase::kFallingBack;
  const bool some = std::any_of(s.legs.begin(), s.legs.end(), [](const Leg& leg) {
    return leg.progress == Leg::Progress::kEnded;
  });
  return some ? MachinePhase::kPartlyDone : MachinePhase::kSent;
}

}  // namespace

std::string_view MachinePhaseName(MachinePhase phase) {
  return kNames[static_cast<std::size_t>(phase)];
}

MachinePhase MachinePhaseOf(const Machine* machine) {
  if (machine == nullptr) return MachinePhase::kNoController;
  if (machine->current) return MachinePhaseOfSwitch(*machine->current, *machine);
  switch (machine->phase) {
    case Phase::kStopping:
      return MachinePhase::kTearingDown;
    case Phase::kStopped:
    case Phase::kFailed:
      return MachinePhase::kOver;
    case Phase::kStarting:
      return MachinePhase::kSettingUp;
    default:
      break;
  }
  const bool joining = std::any_of(machine->actuators.begin(), machine->actuators.end(),
                                   [](const KnownActuator& r) { return r.command.has_value(); });
  if (joining) return MachinePhase::kJoining;
  return machine->emergency.stop ? MachinePhase::kStopped : MachinePhase::kAtRest;
}

}  // namespace musher::simulation
