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

bool IsRequested(const Switch& s) {
  return s.purpose == Purpose::kRequested || s.purpose == Purpose::kStartUpActivate ||
         s.purpose == Purpose::kStartUpCheck;
}

State TargetOf(const action::Record& record) {
  return State(ArgumentOf(record.arguments, "target"));
}

}  // namespace musher::simulation
