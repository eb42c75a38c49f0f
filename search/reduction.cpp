#include "musher/search/reduction.hpp"

#include <algorithm>

namespace musher::search {
namespace {

// Whether the controller of this world waits for the actuators that it has found, and nothing else
// than their messages can happen.
bool IsDiscovering(const Model& model, const World& world) {
  const Machine& machine = world.machine;
  const bool waits = machine.phase == Phase::kStarting && !machine.start_up.set_up &&
                     !machine.start_up.finishing && !machine.start_up.by_hand && !machine.current &&
                     !machine.waiting && !machine.emergency.stop;
  const bool disturbed = world.faults_left > 0 || world.stopped || world.battery ||
                         world.at_start || model.releases || !world.outbox.empty() ||
                         !world.links.empty();
  return waits && !disturbed;
}

bool IsOfTearDown(const ActuatorReport& report) {
  return report.state == kTearDown || report.target == kTearDown;
}

// Whether it runs, was found running, and leads to no TearDown.
bool IsFound(const MachineConfig& config, const SimActuator& actuator, const KnownActuator& known) {
  const ActuatorCore& core = actuator.core;
  const bool runs = actuator.alive && actuator.visible && !actuator.end && !actuator.hung &&
                    actuator.late.empty() && core.report.state != config.default_state;
  const bool ends = IsOfTearDown(core.report) || IsOfTearDown(known.report) ||
                    (core.waiting && core.waiting->command.target == kTearDown) ||
                    std::ranges::any_of(actuator.replies, [](const event::Replied& reply) {
                      return IsOfTearDown(reply.report);
                    });
  return runs && !ends && known.process.launch == Launch::kFoundRunning && !known.fault &&
         !known.held && !known.down_requested && !known.process.termination;
}

// Whether nothing happens at the actuator: it only has to answer.
bool IsIdle(const SimActuator& actuator) {
  return actuator.work == Work::kNone && !actuator.core.waiting;
}

}  // namespace

std::optional<ActuatorIndex> SearchedAlone(const Model& model, const World& world) {
  if (!model.reduces || !IsDiscovering(model, world)) return std::nullopt;
  std::optional<ActuatorIndex> first;
  int idle = 0;
  for (const ActuatorIndex i : world.actuators.Indices()) {
    const SimActuator& actuator = world.actuators[i];
    const KnownActuator& known = world.machine.actuators[i];
    if (!IsFound(model.config, actuator, known)) return std::nullopt;
    if (known.presence == Presence::kPresent) continue;
    if (!known.set_up_by) return std::nullopt;
    const bool sends = actuator.status_due || !actuator.replies.empty();
    if (!IsIdle(actuator) || !sends) continue;
    ++idle;
    if (!first) first = i;
  }
  return idle > 1 ? first : std::nullopt;
}

}  // namespace musher::search
