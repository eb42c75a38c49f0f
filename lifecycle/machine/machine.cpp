#include "musher/lifecycle/machine/machine.hpp"

namespace musher {
namespace {

constexpr std::size_t kLongestHost = 64;  // in messages

}  // namespace

std::string_view PhaseName(Phase phase) {
  return fields::NameOf(phase);
}

std::string_view PresenceName(Presence presence) {
  return fields::NameOf(presence);
}

std::string_view StoredName(Stored what) {
  switch (what) {
    case Stored::kEpoch:
      return "epoch";
    case Stored::kEmergencyStops:
      return "emergency stop";
    case Stored::kPolicy:
      return "policy";
    case Stored::kStopIntent:
      return "intent to stop";
    case Stored::kRemoteActuators:
      return "list of remote actuators";
    case Stored::kActuators:
      return "list of actuators";
    case Stored::kJournal:
      break;
  }
  return "journal";
}

Machine MakeMachine(const MachineConfig& config) {
  Machine machine;
  machine.state = config.default_state;
  machine.actuators.resize(config.actuators.size());
  for (KnownActuator& known : machine.actuators) known.report.state = config.default_state;
  return machine;
}

StoredStops StopsOf(const Machine& machine) {
  StoredStops stops;
  if (machine.emergency.stop) stops.engaged.push_back(*machine.emergency.stop);
  stops.engaged.insert(stops.engaged.end(), machine.emergency.others.begin(),
                       machine.emergency.others.end());
  stops.released = machine.emergency.released;
  stops.replaced = machine.emergency.replaced;
  stops.awaits_request = machine.emergency.awaits_request;
  stops.unread = machine.emergency.unread;
  stops.engagements = machine.emergency.engagements;
  return stops;
}

bool MustBeSetAgain(const Machine& machine, const KnownActuator& known) {
  const bool stopped = known.report.held_by_stop || machine.emergency.awaits_request;
  return stopped && !known.set_again;
}

std::optional<Error> PartialFaultOf(const KnownActuator& known) {
  if (known.presence != Presence::kPresent) return std::nullopt;
  if (known.tolerated) return known.tolerated;
  const ActuatorReport& report = known.report;
  if (report.degraded_code == kCodeOk) return std::nullopt;
  return Error{report.degraded_code, report.degraded_reason};
}

std::optional<Error> SecondProcessOf(const KnownActuator& known) {
  if (!known.other) return std::nullopt;
  const ActuatorReport& other = *known.other;
  const std::string place = other.busy() ? "is switching to " + other.target.Shortened()
                                         : "is in " + other.state.Shortened();
  return Error{kCodeStatusError, "a second process of it runs and " + place + ": process " +
                                     std::to_string(other.pid) + " of host " +
                                     other.host.substr(0, kLongestHost) +
                                     ", which no command reaches; end one of the two"};
}

std::optional<Error> TroubleOf(const KnownActuator& known) {
  if (known.fault) return known.fault;
  const auto second = SecondProcessOf(known);
  return second ? second : PartialFaultOf(known);
}

std::vector<std::string> Degraded(const MachineConfig& config, const Machine& machine) {
  std::vector<std::string> names;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    if (TroubleOf(machine.actuators[i])) names.push_back(config.actuators[i].name);
  }
  return names;
}

}  // namespace musher
