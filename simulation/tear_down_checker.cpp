#include "musher/simulation/tear_down_checker.hpp"

#include <algorithm>

namespace musher::simulation {

// An accepted TearDown continues, even if its controller ends, until a controller begins that an
// operator has started. The operator may have started it before the TearDown: it listens for other
// controllers first. Each disk stores the intent of the controllers of its host only.
void TearDownChecker::CheckStaysDown(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  if (machine.stopping && !accepted_tear_down_) {
    accepted_tear_down_ = AcceptedTearDown{controller.serial(), controller.host()};
  }
  if (!MustStayDown(controller) || machine.phase != Phase::kRunning) return;
  ReportViolation(Invariant::kNoStartAfterTearDown,
                  "a supervisor's restart brings the machine to " + machine.state +
                      " after an accepted TearDown");
}

void TearDownChecker::OnStart(const SimulatedController& controller, const std::string& name) {
  if (!MustStayDown(controller)) return;
  ReportViolation(Invariant::kNoStartAfterTearDown,
                  "a supervisor's restart starts " + name + " after an accepted TearDown");
}

void TearDownChecker::OnBegunByPerson(const SimulatedController& controller) {
  const auto runs = [&](const ActuatorConfig& actuator) {
    return !actuator.command.empty() &&
           robot_.processes().PidOf(actuator.name, controller.host()) != 0;
  };
  if (std::ranges::none_of(config_.actuators, runs)) torn_down_alone_.clear();
}

void TearDownChecker::CheckMayStart(const SimulatedController& controller,
                                    const std::string& name) {
  const auto down = torn_down_alone_.find(name);
  if (down == torn_down_alone_.end()) return;
  const std::size_t host = down->second;
  torn_down_alone_.erase(down);
  if (host != controller.host() || context_.state_lost) return;
  ReportViolation(Invariant::kStaysDown,
                  "a controller starts " + name + ", which a person has torn down alone");
}

void TearDownChecker::NoteTornDownAlone(const SimulatedController& controller,
                                        const SwitchResult& result) {
  const bool degraded = result.outcome == SwitchOutcome::kDoneDegraded;
  if (result.target != kTearDown || !(result.done() || degraded)) return;
  if (result.actuator.empty()) return torn_down_alone_.clear();  // all are down alike
  if (!degraded) torn_down_alone_[result.actuator] = controller.host();
}

// Whether a supervisor has started the controller after the TearDown, and finds it on its disk.
bool TearDownChecker::MustStayDown(const SimulatedController& controller) const {
  return accepted_tear_down_ && !context_.state_lost &&
         accepted_tear_down_->host == controller.host() &&
         accepted_tear_down_->controller != controller.serial();
}

// Whether the actuator runs for another controller, on the host of that controller, which began
// while the controller `process`, which is to tear down, was stopped or disconnected; otherwise
// `process` would have released the machine.
bool TearDownChecker::RunsForAnother(const SimulatedController& process, ActuatorIndex i,
                                     std::size_t host) const {
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* other = robot_.controller(which);
    if (other == nullptr || other->serial() == process.serial() || !other->leads()) continue;
    const std::int32_t pid = other->shell().machine().actuators[i].process.pid;
    const bool its_own =
        pid != 0 && pid == robot_.processes().PidOf(config_.actuators[i].name, host);
    if (other->host() == host && host != process.host() && its_own) return true;
  }
  return false;
}

// Notes which process of each actuator a controller has received a report of.
void TearDownChecker::NoteReceived(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  PerActuator<Incarnation>& last = last_received_[controller.serial()];
  last.resize(machine.actuators.size());
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorReport& report = machine.actuators[i].report;
    if (report.incarnation == last[i]) continue;
    last[i] = report.incarnation;
    received_.insert({controller.host(), i, report.host, report.incarnation});
  }
}

// Whether a controller can know of a process on another host: it has received a report of the
// process, or an earlier controller of its host has, and has stored that. There are two cases where
// it cannot: it takes the machine over from a controller of a third host while the link to the
// process is cut, or its disk was full or stalled. A process that it never received and that no
// disk of its host has looks like a process that was never started.
bool TearDownChecker::IsKnown(const SimulatedController& controller, ActuatorIndex i,
                              std::size_t host, const ActuatorReport& report) const {
  return host == controller.host() ||
         (!context_.state_lost &&
          received_.contains({controller.host(), i, report.host, report.incarnation}));
}

// TearDown is reported as done. That concerns the processes on the controller's own host, which the
// controller finds by their names, and the processes of other hosts that it can know of.
void TearDownChecker::CheckTornDown(const SimulatedController& controller,
                                    const SwitchResult& result) {
  if (result.target != kTearDown || !result.actuator.empty()) return;
  if (result.outcome != SwitchOutcome::kDone) return;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    const State lost_in = LostIn(controller, i);
    if (config_.actuators[i].Lists(kTearDown) && !lost_in.empty()) {
      ReportViolation(Invariant::kTearDownIsComplete, "TearDown is reported as done, and " + name +
                                                          " has ended in " + lost_in +
                                                          " without its own");
    }
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(name, host);
      if (report == nullptr || report->state == kTearDown || processes_.IsDuplicated(name))
        continue;
      const auto reported = context_.false_reporters.find(name);
      if (reported != context_.false_reporters.end() && reported->second == kTearDown) continue;
      // The controller may have no report yet of an actuator that is starting.
      const KnownActuator& known = controller.shell().machine().actuators[i];
      const bool received = known.report.incarnation == report->incarnation;
      if (!received && !config_.RankOf(report->state)) continue;
      if (!received && RunsForAnother(controller, i, host)) continue;
      if (!received && !IsKnown(controller, i, host, *report)) continue;
      ReportViolation(Invariant::kTearDownIsComplete, "TearDown is reported as done, and " + name +
                                                          " still runs in " + report->state +
                                                          " on host " + robot_.hosts().name(host));
    }
  }
}

}  // namespace musher::simulation
