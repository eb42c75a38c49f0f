// Actuators that are not set up in time, and why.

#include "musher/lifecycle/startup/start_up.hpp"

namespace musher {

void StartUp::CheckDeadlines() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    ActuatorRecord& record = Of(i);
    if (!record.set_up_by || *record.set_up_by > now_ || record.presence == Presence::kPresent) {
      continue;
    }
    record.set_up_by.reset();
    if (record.fault && record.presence != Presence::kStarting)
      continue;  // the known fault says more
    if (machine_.start_up.finishing)
      continue;  // an actuator that does not run need not be torn down
    // The reason of a failed SetUp says more as well.
    const ActuatorReport& report = record.report;
    const bool failed = record.fault && report.incarnation != record.process.dead &&
                        report.state == config_.default_state && report.outcome_code != kCodeOk;
    if (!failed) Degrade(i, kCodeTimeout, NotSetUp(i), record.cause);
    FallBack(i);
  }
}

// Why it is not set up by its deadline.
RecordText StartUp::NotSetUp(ActuatorIndex i) const {
  const ActuatorConfig& actuator = ConfigOf(i);
  const ActuatorRecord& record = Of(i);
  const Duration within = config_.TimeFor(i, kSetUp);
  const bool announced =
      record.report.incarnation != 0 && record.report.incarnation != record.process.dead;
  if (actuator.protocol == Protocol::kRos2Lifecycle && !announced) {
    const std::string folder = config_.name_space.empty() ? "/" : "/" + config_.name_space + "/";
    return texts::NodeNotDiscovered(folder + actuator.name, within, record.process.pid);
  }
  if (record.process.pid == 0 || announced || actuator.protocol != Protocol::kMusher) {
    return texts::SetUpTimeout(within);
  }
  for (const ActuatorIndex other : machine_.actuators.Indices()) {
    const bool shared = Of(other).process.pid == record.process.pid;  // `i` itself is not present
    if (!shared || Of(other).presence != Presence::kPresent) continue;
    return texts::NotAnnouncedBeside(actuator.name, ConfigOf(other).name, within,
                                     record.process.pid);
  }
  return texts::NotAnnounced(actuator.name, actuator.command, within, record.process.pid);
}

}  // namespace musher
