#include "musher/simulation/stop_checker.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"

namespace musher::simulation {
namespace {

// What an actuator's own stop names where no permit to move has arrived.
constexpr std::string_view kPermitKey = "[safety] permit_ms";
// The first permit of a console counts as fresh, however long it took: 400 ms at most, and 80 ms on
// links with faults.
constexpr Duration kPermitSlack = Milliseconds(500);
constexpr Duration kPermitPeriod = Milliseconds(20);  // of the checks

}  // namespace

void StopChecker::OnStopEngaged(std::size_t panel, StopId id) {
  engaged_[id] = panel;
  last_of_panel_[panel] = id;
  engaged_at_[id] = robot_.network().now();
}

// A controller publishes a stop. Only a controller releases one.
void StopChecker::OnStopPublished(const SimulatedController& controller,
                                  const msg::EmergencyStop& stop) {
  release_.OnStopPublished(controller, stop);
  if (stop.engaged) {
    accepted_stops_[StopId(stop.id)].insert(controller.host());
  } else {
    released_[StopId(stop.id)].insert(robot_.FolderOf(controller));
    released_at_ = robot_.network().now();
  }
}

// A release is stored in the folder of the controller that received it. If a controller of another
// host leads afterwards, a panel that is still available engages the stop again; that of another
// user has it engaged in its own folder.
bool StopChecker::ReleasedElsewhere() const {
  const SimulatedController* leader = robot_.leader();
  return leader != nullptr &&
         std::any_of(released_.begin(), released_.end(), [this, leader](const auto& release) {
           return !release.second.contains(robot_.FolderOf(*leader));
         });
}

// Whether a stop is still engaged. A panel keeps its last stop only. An earlier stop is lost if no
// controller had received it, if the disk that had it is lost, or if that disk is on another host
// than the controller that leads. A program publishes its stop for some time only: whether the stop
// is engaged later depends on which controllers and actuators have received it.
StopChecker::Open StopChecker::StopIsOpen() const {
  const SimulatedController* leader = robot_.leader();
  Open open = Open::kNo;
  for (const auto& [id, panel] : engaged_) {
    if (released_.contains(id)) continue;
    const auto accepted = accepted_stops_.find(id);
    const bool kept = accepted != accepted_stops_.end() && leader != nullptr &&
                      accepted->second.contains(leader->host()) && !context_.state_lost;
    const bool published = last_of_panel_.at(panel) == id && !withdrawn_.contains(id);
    if (kept || published) return Open::kYes;
    if (withdrawn_.contains(id)) open = Open::kMaybe;
  }
  return open;
}

void StopChecker::CheckStopsAtRest(const Machine& machine) {
  const bool known = machine.emergency.stop.has_value();
  const Open is_open = StopIsOpen();
  const bool open = is_open == Open::kMaybe ? known : is_open == Open::kYes;
  const auto excused = [&](bool latched) {
    return latched && !open && (context_.state_lost || ReleasedElsewhere());
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
bool StopChecker::IsStopped(const std::string& name, std::size_t host,
                            const ActuatorReport& report) const {
  if (robot_.processes().HasPower(name, host)) return !robot_.processes().IsPowered(name, host);
  const bool off = !Rises(config_, kDeActive, report.state) && !report.busy();
  return report.emergency_stop != 0 || off;
}

// Whether anything but the program that engaged it has the stop: an earlier one may be all that
// holds the machine. The writes of a second machine's controllers are not seen here. Without a
// controller the stop stays published for a minute: then an actuator that has latched it may have
// ended.
bool StopChecker::HasArrived(StopId id) const {
  if (robot_.StopStaysPublished(id)) return latched_.contains(id);
  if (accepted_stops_.contains(id) || released_.contains(id)) return true;
  for (const std::size_t which : {0, 1}) {
    const SimulatedController* controller = robot_.controller(which);
    if (controller == nullptr) continue;
    const EmergencyStopState& known = controller->shell().machine().emergency;
    const bool beside = std::ranges::count(known.others, id, &EmergencyStop::id) != 0;
    if ((known.stop && known.stop->id == id) || beside) return true;
  }
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(config_.actuators[i].name, host);
      if (report == nullptr) continue;
      if (report->emergency_stop == id || std::ranges::count(report->other_stops, id) != 0) {
        return true;
      }
    }
  }
  return false;
}

// The state in which the actuator was on when its process ended, as far as every controller that
// leads knows that; "": it was off, had latched a stop, or one does not know it.
State StopChecker::LostOnIn(ActuatorIndex i) const {
  State in;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* controller = robot_.controller(which);
    if (controller == nullptr || !controller->leads()) continue;
    in = LostIn(*controller, i);
    const std::string& host = controller->shell().machine().actuators[i].report.host;
    const auto last = context_.reports.find({config_.actuators[i].name, host});
    const bool latched = last != context_.reports.end() && last->second.emergency_stop != 0;
    if (latched || !Rises(config_, kUninitialized, in)) return {};
  }
  return in;
}

// Every actuator of the machine is stopped, unless the stop was released meanwhile. The program
// takes the word of the controller that it reaches. That controller cannot know of a process beyond
// a cut link if no controller of its host has ever received the process.
void StopChecker::OnStopConfirmed(StopId id) {
  if (released_at_ && *released_at_ >= engaged_at_[id]) return;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    if (const State lost_in = LostOnIn(i); !lost_in.empty()) {
      ReportViolation(Invariant::kStopIsConfirmed, "the machine is reported as stopped, and " +
                                                       name + " has ended in " + lost_in);
    }
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(name, host);
      if (report == nullptr || IsStopped(name, host, *report)) continue;
      const auto knows = [&](const SimulatedController* controller) {
        return controller == nullptr || !controller->leads() ||
               tear_down_.IsKnown(*controller, i, host, *report);
      };
      if (processes_.IsDuplicated(name) || !knows(robot_.controller(0))) continue;
      if (robot_.leader() == nullptr || !knows(robot_.controller(1))) continue;
      ReportViolation(Invariant::kStopIsConfirmed, "the machine is reported as stopped, and " +
                                                       name + " is on in " + report->state +
                                                       " on host " + robot_.hosts().name(host));
    }
  }
  if (!HasArrived(id)) {
    ReportViolation(Invariant::kStopIsConfirmed,
                    "the machine is reported as stopped, and the stop has arrived nowhere");
  }
}

// Runs after each step of an actuator.
void StopChecker::CheckStopped(const std::string& name, std::size_t host,
                               const ActuatorReport& before, const ActuatorReport& report) {
  const bool reports_on = !report.busy() && !report.held_by_stop && report.incarnation != 0 &&
                          Rises(config_, kUninitialized, report.state);
  const SimulatedProcesses& processes = robot_.processes();
  if (reports_on && processes.HasPower(name, host) && !processes.IsPowered(name, host)) {
    ReportViolation(
        Invariant::kEmergencyStopReported,
        name + " reports " + report.state + " with its power off, and not that a stop holds it");
  }
  if (stops_of_other_.contains(report.emergency_stop)) {
    ReportViolation(Invariant::kReachesMeantMachine,
                    name + " has latched an emergency stop that is meant for another machine");
  }
  if (report.emergency_stop != 0) latched_.insert(report.emergency_stop);
  latched_.insert(report.other_stops.begin(), report.other_stops.end());
  release_.NoteLatched({name, host}, before, report);
  if (report.emergency_stop == 0 || before.emergency_stop != report.emergency_stop) return;
  if (!report.busy()) idle_and_stopped_.emplace_back(name, host);
  if (before.busy() && MaySwitchOn(config_, before.state, report.state)) {
    ReportViolation(Invariant::kEmergencyStopHolds,
                    name + " has switched from " + before.state + " to " + report.state +
                        ", which may switch it on, although it has latched an emergency stop");
  }
}

// Only the release of a stop ends it.
void StopChecker::CheckStaysStopped(const std::string& name, const ActuatorReport& before,
                                    const ActuatorReport& report) {
  const bool ended = before.emergency_stop != 0 && report.emergency_stop == 0;
  if (!ended || released_.contains(before.emergency_stop)) return;
  ReportViolation(Invariant::kEmergencyStopLatched,
                  name + " is not stopped any more, although no controller has released its stop");
}

// A release was answered. Whatever was released before, no actuator that the controller leads may
// report it any more. A process of which nothing has arrived yet receives the release as it starts.
void StopChecker::CheckReleased(const SimulatedController& controller, const Result<>& released) {
  if (!released) return;
  const Machine& machine = controller.shell().machine();
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    const KnownActuator& known = machine.actuators[i];
    if (report == nullptr || known.presence != Presence::kPresent) continue;
    const bool second = known.other && known.other->incarnation == report->incarnation;
    if (report->incarnation != known.report.incarnation && !second) continue;
    if (!released_.contains(report->emergency_stop)) continue;
    ReportViolation(Invariant::kReleaseIsConfirmed,
                    "the emergency stops are reported as released, and " +
                        config_.actuators[i].name + " has latched one of them");
  }
}

// Runs after the whole step of an actuator.
void StopChecker::CheckPower() {
  for (const auto& [name, host] : std::exchange(idle_and_stopped_, {})) {
    const ActuatorReport* report = robot_.processes().ReportOf(name, host);
    if (report == nullptr || report->busy() || report->emergency_stop == 0) continue;
    if (!robot_.processes().IsPowered(name, host)) continue;
    ReportViolation(Invariant::kEmergencyStopHolds,
                    name + " in " + report->state +
                        " has its power on although it has latched an emergency stop");
  }
}

// A stop that an actuator has engaged by itself, as no permit has arrived. Nothing publishes it
// before a controller does.
void StopChecker::NotePermitStops(const ActuatorCore& core) {
  constexpr std::size_t kOfPermits = 50;  // beside the panels
  if (!config_.permit) return;
  for (const EmergencyStop& stop : core.stops) {
    if (stop.by != kPermitKey || engaged_.contains(stop.id)) continue;
    OnStopEngaged(kOfPermits, stop.id);
    OnStopWithdrawn(stop.id);
  }
}

// An actuator is off, by its hardware, some time after the last permit that it can have.
void StopChecker::CheckPermits() {
  const Time now = robot_.network().now();
  if (!config_.permit || now < check_permits_at_) return;
  check_permits_at_ = now + kPermitPeriod;
  const SimulatedProcesses& processes = robot_.processes();
  for (const ActuatorConfig& actuator : config_.actuators) {
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorCore* core = processes.CoreOf(actuator.name, host);
      if (core == nullptr || !processes.IsPowered(actuator.name, host)) continue;
      // It was switched on by a callback whose end is not known yet; the stop action runs again.
      if (core->report.busy() && !core->stops.empty()) continue;
      const auto frozen = processes.FrozenUntil(actuator.name, host);
      if (frozen && (*frozen == Time::max() || now - *frozen < kPermitSlack)) continue;
      const auto given = permits_.find(core->permit.stamp);
      const bool known = given != permits_.end();
      if (known && now - given->second <= *config_.permit + kPermitSlack) continue;
      ReportViolation(Invariant::kStopsWithoutPermit,
                      actuator.name + " is on in " + core->report.state +
                          (known ? ' ' + std::to_string(ToMilliseconds(now - given->second)) +
                                       " ms after the last permit to move"
                                 : ", and no permit to move was given"));
    }
  }
}

// The engaged stops of panels have no identity, and are latched: they reach a machine that comes
// later, too.
void StopChecker::TakeStopsOf(const StopChecker& other) {
  constexpr std::size_t kPanels = 2;
  for (const auto& [panel, id] : other.last_of_panel_) {
    if (panel < kPanels) OnStopEngaged(panel, id);
  }
}

}  // namespace musher::simulation
