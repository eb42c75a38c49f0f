#include "musher/simulation/subject_checker.hpp"

namespace musher::simulation {

void CheckerContext::ReportViolation(Invariant invariant, const std::string& what) {
  if (violation) return;
  violation = {invariant, robot.age(), what};
}

SubjectChecker::SubjectChecker(CheckerContext& context)
    : context_(context), robot_(context.robot), config_(context.robot.config()) {}

std::uint64_t SubjectChecker::SerialOf(const Machine& machine) const {
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* controller = robot_.controller(which);
    if (controller != nullptr && &controller->shell().machine() == &machine) {
      return controller->serial();
    }
  }
  return 0;
}

State SubjectChecker::LostIn(const SimulatedController& controller, ActuatorIndex i) const {
  const std::string& name = config_.actuators[i].name;
  const KnownActuator& known = controller.shell().machine().actuators[i];
  const auto last = context_.reports.find({name, known.report.host});
  if (!known.met || last == context_.reports.end()) return {};
  const ActuatorReport& report = last->second;
  const bool known_last = report.incarnation == known.report.incarnation;
  const bool was_in_use = config_.RankOf(report.state) && report.state != kTearDown;
  if (!known_last || !was_in_use || context_.false_reporters.contains(name)) return {};
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    if (robot_.processes().ReportOf(name, host) != nullptr) return {};  // it runs
  }
  return report.state;
}

bool SubjectChecker::WasDisturbed(const SimulatedController& controller, const std::string& name,
                                  std::size_t host, Duration within) const {
  const Time now = robot_.network().now();
  const auto recent = [&](const std::optional<Time>& until) {
    return until && (*until == Time::max() || now - *until < within);
  };
  const SimulatedProcesses& processes = robot_.processes();
  const std::string& endpoint = processes.EndpointOf(name, host);
  return recent(processes.FrozenUntil(name, host)) || recent(controller.thawed) ||
         recent(context_.link_faults_until) ||
         recent(robot_.hosts().BlockedUntil(endpoint, controller.endpoint())) ||
         recent(robot_.hosts().BlockedUntil(controller.endpoint(), endpoint));
}

bool IsRequested(const Switch& s) {
  return s.purpose == Purpose::kRequested || s.purpose == Purpose::kStartUpActivate ||
         s.purpose == Purpose::kStartUpCheck;
}

State TargetOf(const action::Record& record) {
  return State(ArgumentOf(record.arguments, "target"));
}

}  // namespace musher::simulation
