// The invariants of emergency stops, and of an accepted TearDown.

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/simulation/checker.hpp"

namespace musher::simulation {

void Checker::OnStopEngaged(std::size_t panel, StopId id) {
  engaged_[id] = panel;
  last_of_panel_[panel] = id;
  engaged_at_[id] = robot_.network().now();
}

// A controller publishes a stop. Only a controller releases one.
void Checker::OnStopPublished(const ControllerProcess& controller, const msg::EmergencyStop& stop) {
  if (stop.engaged) {
    accepted_stops_[StopId(stop.id)].insert(controller.host());
  } else {
    released_[StopId(stop.id)].insert(controller.host());
    released_at_ = robot_.network().now();
  }
}

// A release is stored on the disk of the host whose controller received it. If a controller of
// another host leads afterwards, a panel that is still available engages the stop again.
bool Checker::ReleasedElsewhere() const {
  const ControllerProcess* leader = robot_.leader();
  return leader != nullptr &&
         std::any_of(released_.begin(), released_.end(), [leader](const auto& release) {
           return !release.second.contains(leader->host());
         });
}

// Whether a stop is still engaged. A panel keeps its last stop only: an earlier one is lost if no
// controller had received it, if it was stored on a disk that is lost, or if it was stored on
// another host than that of the controller that leads. Whether one is engaged that a program has
// published, which publishes it no more, depends on who has received it.
Checker::Open Checker::StopIsOpen() const {
  const ControllerProcess* leader = robot_.leader();
  Open open = Open::kNo;
  for (const auto& [id, panel] : engaged_) {
    if (released_.contains(id)) continue;
    const auto accepted = accepted_stops_.find(id);
    const bool kept = accepted != accepted_stops_.end() && leader != nullptr &&
                      accepted->second.contains(leader->host()) && !state_lost_;
    const bool published = last_of_panel_.at(panel) == id && !withdrawn_.contains(id);
    if (kept || published) return Open::kYes;
    if (withdrawn_.contains(id)) open = Open::kMaybe;
  }
  return open;
}

void Checker::CheckStopsAtRest(const Machine& machine) {
  const bool known = machine.emergency.stop.has_value();
  const Open is_open = StopIsOpen();
  const bool open = is_open == Open::kMaybe ? known : is_open == Open::kYes;
  const auto excused = [&](bool latched) {
    return latched && !open && (state_lost_ || ReleasedElsewhere());
  };
  const std::string what = open ? " although one is engaged" : " although all stops are released";
  if (known != open && !excused(known)) {
    return ReportViolation(
        Invariant::kEmergencyStopLatched,
        std::string("the controller has ") + (known ? "an" : "no") + " emergency stop" + what);
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    if (report == nullptr || machine.actuators[i].presence != Presence::kPresent) continue;
    const bool latched = report->emergency_stop != 0;
    if (latched == open || excused(latched)) continue;
    ReportViolation(Invariant::kEmergencyStopLatched, config_.actuators[i].name + " has latched " +
                                                          (latched ? "an" : "no") +
                                                          " emergency stop" + what);
  }
}

// Nothing of it is on: by its hardware, or by its report where that is not known.
bool Checker::IsStopped(const std::string& name, std::size_t host,
                        const ActuatorReport& report) const {
  if (robot_.processes().HasPower(name, host)) return !robot_.processes().IsPowered(name, host);
  const bool off = !Rises(config_, kDeActive, report.state) && !report.busy();
  return report.emergency_stop != 0 || off;
}

// Every actuator of the machine is stopped, unless the stop was released meanwhile. The program
// goes by the controller that it reaches, which cannot know of a process beyond a cut link that no
// controller of its host has ever received.
void Checker::OnStopConfirmed(StopId id) {
  ++checks_;
  if (released_at_ && *released_at_ >= engaged_at_[id]) return;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(name, host);
      if (report == nullptr || IsStopped(name, host, *report)) continue;
      const auto knows = [&](const ControllerProcess* controller) {
        return controller == nullptr || !controller->leads() ||
               IsKnown(*controller, i, host, *report);
      };
      if (duplicated_.contains(name) || !knows(robot_.controller(0))) continue;
      if (robot_.leader() == nullptr || !knows(robot_.controller(1))) continue;
      ReportViolation(Invariant::kStopIsConfirmed, "the machine is reported as stopped, and " +
                                                       name + " is on in " + report->state +
                                                       " on host " + robot_.hosts().name(host));
    }
  }
}

// Runs after each step of an actuator.
void Checker::CheckStopped(const std::string& name, std::size_t host, const ActuatorReport& before,
                           const ActuatorReport& report) {
  const bool reports_on = !report.busy() && !report.held_by_stop && report.incarnation != 0 &&
                          Rises(config_, kUninitialized, report.state);
  const Processes& processes = robot_.processes();
  if (reports_on && processes.HasPower(name, host) && !processes.IsPowered(name, host)) {
    ReportViolation(
        Invariant::kEmergencyStopReported,
        name + " reports " + report.state + " with its power off, and not that a stop holds it");
  }
  if (stops_of_other_.contains(report.emergency_stop)) {
    ReportViolation(Invariant::kReachesMeantMachine,
                    name + " has latched an emergency stop that is meant for another machine");
  }
  if (report.emergency_stop == 0 || before.emergency_stop != report.emergency_stop) return;
  if (!report.busy()) idle_and_stopped_.emplace_back(name, host);
  if (before.busy() && MaySwitchOn(config_, before.state, report.state)) {
    ReportViolation(Invariant::kEmergencyStopHolds,
                    name + " has switched from " + before.state + " to " + report.state +
                        ", which may switch it on, although it has latched an emergency stop");
  }
}

// A release was answered. Whatever was released before, no actuator that the controller leads may
// report it any more.
void Checker::CheckReleased(const ControllerProcess& controller, const Result<>& released) {
  if (!released) return;
  const Machine& machine = controller.shell().machine();
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    if (report == nullptr || machine.actuators[i].presence != Presence::kPresent) continue;
    if (!released_.contains(report->emergency_stop)) continue;
    ReportViolation(Invariant::kReleaseIsConfirmed,
                    "the emergency stops are reported as released, and " +
                        config_.actuators[i].name + " has latched one of them");
  }
}

// Runs after the whole step of an actuator.
void Checker::CheckPower() {
  for (const auto& [name, host] : std::exchange(idle_and_stopped_, {})) {
    const ActuatorReport* report = robot_.processes().ReportOf(name, host);
    if (report == nullptr || report->busy() || report->emergency_stop == 0) continue;
    if (!robot_.processes().IsPowered(name, host)) continue;
    ReportViolation(Invariant::kEmergencyStopHolds,
                    name + " in " + report->state +
                        " has its power on although it has latched an emergency stop");
  }
}

// An accepted TearDown continues, even if its controller ends, until a controller begins that an
// operator has started. The operator may have started it before the TearDown: it listens for other
// controllers first. Each disk stores the intent of the controllers of its host only.
void Checker::CheckStaysDown(const ControllerProcess& controller) {
  const Machine& machine = controller.shell().machine();
  if (machine.stopping && !accepted_tear_down_) {
    accepted_tear_down_ = AcceptedTearDown{controller.serial(), controller.host()};
  }
  if (!accepted_tear_down_ || state_lost_ || accepted_tear_down_->host != controller.host()) return;
  const bool is_up =
      machine.phase == Phase::kRunning && accepted_tear_down_->controller != controller.serial();
  if (!is_up) return;
  ReportViolation(Invariant::kNoStartAfterTearDown,
                  "a supervisor's restart brings the machine to " + machine.state +
                      " after an accepted TearDown");
}

// Whether the actuator runs for another controller, on the host of that controller, which began
// while the controller `process`, which is to tear down, was stopped or disconnected; otherwise
// `process` would have released the machine.
bool Checker::RunsForAnother(const ControllerProcess& process, ActuatorIndex i,
                             std::size_t host) const {
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* other = robot_.controller(which);
    if (other == nullptr || other->serial() == process.serial() || !other->leads()) continue;
    const std::int32_t pid = other->shell().machine().actuators[i].process.pid;
    const bool its_own =
        pid != 0 && pid == robot_.processes().PidOf(config_.actuators[i].name, host);
    if (other->host() == host && host != process.host() && its_own) return true;
  }
  return false;
}

// Notes which process of each actuator a controller has received a report of.
void Checker::NoteReceived(const ControllerProcess& controller, Seen& seen) {
  const Machine& machine = controller.shell().machine();
  seen.received.resize(machine.actuators.size());
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorReport& report = machine.actuators[i].report;
    if (report.incarnation == seen.received[i]) continue;
    seen.received[i] = report.incarnation;
    received_.insert({controller.host(), i, report.host, report.incarnation});
  }
}

// Whether a controller can know of a process on another host: it has received a report of it, or an
// earlier controller of its host has, which stores that. A controller that takes the machine over
// from one of a third host while the link to the process is cut, or whose disk was full or stalled,
// cannot: what it never received and no disk of its host has is indistinguishable from a process
// that was never started.
bool Checker::IsKnown(const ControllerProcess& controller, ActuatorIndex i, std::size_t host,
                      const ActuatorReport& report) const {
  return host == controller.host() ||
         (!state_lost_ &&
          received_.contains({controller.host(), i, report.host, report.incarnation}));
}

// TearDown is reported as done. It concerns the processes on the controller's own host, which it
// finds by their names, and those of other hosts that it can know of.
void Checker::CheckTornDown(const ControllerProcess& controller, const SwitchResult& result) {
  if (result.target != kTearDown || !result.actuator.empty()) return;
  if (result.outcome != SwitchOutcome::kDone) return;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(name, host);
      if (report == nullptr || report->state == kTearDown || duplicated_.contains(name)) continue;
      const auto reported = false_reporters_.find(name);
      if (reported != false_reporters_.end() && reported->second == kTearDown) continue;
      // The controller may have no report yet of an actuator that is starting.
      const ActuatorRecord& record = controller.shell().machine().actuators[i];
      const bool received = record.report.incarnation == report->incarnation;
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
