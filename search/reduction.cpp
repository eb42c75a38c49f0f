#include "musher/search/reduction.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace musher::search {
namespace {

// Whether no fault is left, nothing is being sent, and the machine is one of one host.
bool IsUndisturbed(const Model& model, const World& world) {
  return world.faults_left == 0 && !world.battery && !world.at_start && !model.releases &&
         world.outbox.empty() && world.links.empty();
}

// Whether the controller of this world waits for the actuators that it has found, and nothing else
// than their messages, their callbacks and their exits can happen.
bool IsDiscovering(const World& world) {
  const Machine& machine = world.machine;
  const bool starts =
      machine.phase == Phase::kStarting && !machine.start_up.set_up && !machine.start_up.by_hand;
  const bool ends = machine.phase == Phase::kStopping && machine.stopping->announced_by;
  return (starts || ends) && !machine.current && !machine.waiting && !machine.emergency.stop &&
         !world.stopped;
}

// Whether the controller may find an actuator in its TearDown, and go on at once.
bool MayFindTearDown(const World& world) {
  const Machine& machine = world.machine;
  return machine.phase == Phase::kStarting && !machine.start_up.finishing &&
         std::ranges::count(world.requests, State(kTearDown), &Request::target) > 0;
}

// Whether the controller goes on only once something has happened at this actuator.
bool IsAwaited(const Model& model, const World& world, const KnownActuator& known) {
  const Machine& machine = world.machine;
  const bool silent = known.presence == Presence::kAbsent || known.presence == Presence::kStarting;
  const bool found = known.process.launch == Launch::kFoundRunning && !known.fault && !known.held &&
                     !known.down_requested && known.kept_in.empty() &&
                     (known.lost_in.empty() || !MayReportLoss(model, world)) &&
                     !known.process.termination && !known.control.rival_until;
  const bool counts = machine.phase == Phase::kStopping
                          ? !machine.start_up.finishing || !machine.start_up.set_up
                          : known.set_up_by.has_value();
  return silent && found && counts;
}

// The actuators, a bit for each, that come after this one, and that a start has not begun to start.
unsigned WaitingFor(const MachineConfig& config, const Machine& machine, ActuatorIndex i) {
  if (machine.phase != Phase::kStarting || machine.start_up.finishing) return 0;
  unsigned waiting = 0;
  for (const ActuatorIndex k : config.actuators.Indices()) {
    const ActuatorConfig& other = config.actuators[k];
    const KnownActuator& known = machine.actuators[k];
    const bool is_after = std::ranges::count(other.after, config.actuators[i].name) > 0;
    const bool not_begun = other.stage <= machine.start_up.stage &&
                           known.presence == Presence::kAbsent &&
                           known.process.launch != Launch::kFoundRunning;
    if (is_after && not_begun) waiting |= 1U << k.value();
  }
  return waiting;
}

bool IsOfTearDown(const ActuatorReport& report) {
  return report.state == kTearDown || report.target == kTearDown;
}

// Whether nothing is left to happen at the actuator but its answer.
bool OnlyAnswers(const MachineConfig& config, const SimActuator& actuator,
                 const KnownActuator& known) {
  const ActuatorCore& core = actuator.core;
  const bool runs = actuator.alive && actuator.visible && !actuator.end && !actuator.hung &&
                    core.report.state != config.default_state;
  const bool idle = actuator.work == Work::kNone && !core.waiting && actuator.late.empty();
  const bool ends = IsOfTearDown(core.report) || IsOfTearDown(known.report) ||
                    std::ranges::any_of(actuator.replies, [](const event::Replied& reply) {
                      return IsOfTearDown(reply.report);
                    });
  return runs && idle && !ends && (actuator.status_due || !actuator.replies.empty());
}

// Whether something happens at the actuator before time passes.
bool IsActive(const SimActuator& actuator) {
  return actuator.end || actuator.status_due || !actuator.replies.empty() ||
         actuator.work == Work::kRunning;
}

// The actuator that is moved while those that were found are awaited: there is another one that
// only answers, and for which the same actuators wait.
std::optional<ActuatorIndex> MovedInDiscovery(const Model& model, const World& world) {
  const Machine& machine = world.machine;
  std::vector<ActuatorIndex> active;
  std::vector<std::pair<ActuatorIndex, unsigned>> answering;
  for (const ActuatorIndex i : world.actuators.Indices()) {
    const SimActuator& actuator = world.actuators[i];
    const KnownActuator& known = machine.actuators[i];
    if (!IsAwaited(model, world, known)) continue;
    if (!OnlyAnswers(model.config, actuator, known)) {
      if (IsActive(actuator)) active.push_back(i);
      continue;
    }
    const unsigned waiting = WaitingFor(model.config, machine, i);
    const auto other =
        std::ranges::find(answering, waiting, &std::pair<ActuatorIndex, unsigned>::second);
    if (other != answering.end()) return other->first;
    answering.emplace_back(i, waiting);
  }
  if (MayFindTearDown(world)) return std::nullopt;
  for (const ActuatorIndex i : active) {
    const unsigned waiting = WaitingFor(model.config, machine, i);
    if (std::ranges::count(answering, waiting, &std::pair<ActuatorIndex, unsigned>::second) > 0)
      return i;
  }
  return std::nullopt;
}

}  // namespace

bool MayReportLoss(const Model& model, const World& world) {
  const bool may_be_requested = world.faults_left > 0 || world.at_start || model.releases;
  return may_be_requested || std::ranges::any_of(world.requests, [](const Request& request) {
           return request.target == kTearDown && request.replies == 0 && !request.abandoned;
         });
}

std::optional<ActuatorIndex> SearchedAlone(const Model& model, const World& world) {
  if (!model.reduces || !IsUndisturbed(model, world)) return std::nullopt;
  return IsDiscovering(world) ? MovedInDiscovery(model, world) : std::nullopt;
}

}  // namespace musher::search
