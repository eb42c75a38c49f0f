// What has to hold of emergency stops, and of the intent to stop.

#include <algorithm>

#include "musher/lifecycle/flow.hpp"
#include "musher/simulation/checker.hpp"

namespace musher::simulation {

void Checker::StopEngaged(std::size_t panel, std::uint64_t id) {
  engaged_[id] = panel;
  last_of_panel_[panel] = id;
}

// What a controller publishes. It alone releases.
void Checker::OnStopPublished(const ControllerProcess& controller, const msg::EmergencyStop& stop) {
  if (stop.engaged) {
    taken_up_.insert(stop.id);
  } else {
    released_[stop.id].insert(controller.host());
  }
}

// A release is on the disk of the host whose controller was asked. Where another host leads
// afterwards, a panel that lives on engages the stop again.
bool Checker::ReleasedElsewhere() const {
  const ControllerProcess* leader = robot_.leader();
  return leader != nullptr &&
         std::any_of(released_.begin(), released_.end(), [leader](const auto& release) {
           return !release.second.contains(leader->host());
         });
}

// Whether one is not released. A panel keeps its last one only: of one before that nothing is left
// if no controller had taken it up, or where that was on a disk that is lost.
bool Checker::StopIsOpen() const {
  return std::any_of(engaged_.begin(), engaged_.end(), [&](const auto& stop) {
    const bool kept = taken_up_.contains(stop.first) && !forgetful_;
    const bool known = kept || last_of_panel_.at(stop.second) == stop.first;
    return known && !released_.contains(stop.first);
  });
}

void Checker::CheckStopsAtRest(const Machine& machine) {
  const bool open = StopIsOpen();
  const auto excused = [&](bool latched) {
    return latched && !open && (forgetful_ || ReleasedElsewhere());
  };
  const std::string what = open ? " although one is engaged" : " although all are released";
  const bool told = machine.emergency_stop.has_value();
  if (told != open && !excused(told)) {
    return ReportViolation(
        Invariant::kStopStays,
        std::string("the controller knows of ") + (told ? "an" : "no") + " emergency stop" + what);
  }
  for (std::size_t i = 0; i < machine.actuators.size(); ++i) {
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    if (report == nullptr || machine.actuators[i].presence != Presence::kPresent) continue;
    const bool latched = report->emergency_stop != 0;
    if (latched == open || excused(latched)) continue;
    ReportViolation(Invariant::kStopStays, config_.actuators[i].name + " has latched " +
                                               (latched ? "an" : "no") + " emergency stop" + what);
  }
}

// A callback ends beside an emergency stop.
void Checker::CheckStopped(const std::string& name, std::size_t host, const ActuatorReport& before,
                           const ActuatorReport& report) {
  const bool says_on = !report.busy() && !report.held_by_stop && report.incarnation != 0 &&
                       Rises(config_, kUninitialized, report.state);
  const Processes& processes = robot_.processes();
  if (says_on && processes.HasPower(name, host) && !processes.IsPowered(name, host)) {
    ReportViolation(Invariant::kStopIsSeen,
                    name + " says that it is in " + report.state +
                        ", with its power off, and not that a stop holds it");
  }
  if (report.emergency_stop == 0 || before.emergency_stop != report.emergency_stop) return;
  if (!report.busy()) free_and_stopped_.emplace_back(name, host);
  if (before.busy() && Rises(config_, before.state, report.state)) {
    ReportViolation(Invariant::kStopWins, name + " has risen from " + before.state + " to " +
                                              report.state +
                                              " although it has latched an emergency stop");
  }
}

// After all that the step of an actuator does.
void Checker::CheckPower() {
  for (const auto& [name, host] : std::exchange(free_and_stopped_, {})) {
    const ActuatorReport* report = robot_.processes().ReportOf(name, host);
    if (report == nullptr || report->busy() || report->emergency_stop == 0) continue;
    if (!robot_.processes().IsPowered(name, host)) continue;
    ReportViolation(Invariant::kStopWins,
                    name + " in " + report->state +
                        " has its power on although it has latched an emergency stop");
  }
}

// An accepted TearDown continues, even if its controller ends, until a controller begins that an
// operator has started. The operator may have started it before the TearDown: it listens for other
// controllers first. Each disk stores the intent of the controllers of its host only.
void Checker::CheckStaysDown(const ControllerProcess& controller) {
  const Machine& machine = controller.shell().machine();
  if (machine.stopping && !stop_asked_) {
    stop_asked_ = StopAsked{controller.serial(), controller.host()};
  }
  if (!stop_asked_ || forgetful_ || stop_asked_->host != controller.host()) return;
  const bool is_up =
      machine.phase == Phase::kRunning && stop_asked_->controller != controller.serial();
  if (!is_up) return;
  ReportViolation(Invariant::kStaysDown, "a supervisor's start brings the machine to " +
                                             machine.state + " after a TearDown that was accepted");
}

// Whether the actuator runs for another controller, on the host of that controller, which began
// while the controller `asked` to tear down was stopped or disconnected; otherwise `asked` would
// have released the machine.
bool Checker::RunsForAnother(const ControllerProcess& asked, std::size_t i,
                             std::size_t host) const {
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* other = robot_.controller(which);
    if (other == nullptr || other->serial() == asked.serial() || !other->leads()) continue;
    const std::int32_t pid = other->shell().machine().actuators[i].process;
    const bool its_own =
        pid != 0 && pid == robot_.processes().PidOf(config_.actuators[i].name, host);
    if (other->host() == host && host != asked.host() && its_own) return true;
  }
  return false;
}

// TearDown is told to be done.
void Checker::CheckTornDown(const ControllerProcess& controller, const SwitchResult& result) {
  if (result.target != kTearDown || !result.actuator.empty()) return;
  if (result.outcome != SwitchOutcome::kDone) return;
  for (std::size_t i = 0; i < config_.actuators.size(); ++i) {
    const std::string& name = config_.actuators[i].name;
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(name, host);
      if (report == nullptr || report->state == kTearDown || twice_.contains(name)) continue;
      // One that starts meanwhile has not been heard yet.
      const ActuatorRecord& record = controller.shell().machine().actuators[i];
      const bool heard = record.report.incarnation == report->incarnation;
      if (!heard && !config_.RankOf(report->state)) continue;
      if (!heard && RunsForAnother(controller, i, host)) continue;
      ReportViolation(Invariant::kDownIsDown, "TearDown is told to be done, and " + name +
                                                  " lives on in " + report->state + " on host " +
                                                  robot_.hosts().name(host));
    }
  }
}

}  // namespace musher::simulation
