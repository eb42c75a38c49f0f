#include "musher/cli/commands/skill/skill_runs.hpp"

#include <utility>
#include <vector>

#include "musher/base/joined.hpp"
#include "musher/cli/machine/meant_actuator.hpp"
#include "musher/cli/machine/skill_offers.hpp"

namespace musher::cli {

AskedRuns AskRunsOf(Link& link, const GlobalOptions& global, const std::string& skill,
                    const std::string& actuator,
                    const std::function<AskedRun(const OfferedSkill& skill)>& ask) {
  const auto offers = SkillOffers::Begin(link, global);
  if (!offers) return {false, Failure{ExitCode::kUsage, offers.error()}};
  const auto meant = MeantActuator::Begin(link, global);
  if (!meant) return {false, Failure{ExitCode::kUsage, meant.error()}};
  if (auto failure = offers.value()->Await(actuator)) return {false, std::move(failure)};
  const auto found = FindSkill(offers.value()->all(), skill, actuator);
  if (!found) return {false, Failure{ExitCode::kNotDone, found.error()}};
  // Nothing is sent before it is known that all of it reaches the machine that is meant.
  AskedRuns asked;
  std::vector<OfferedSkill> of_machine;
  std::vector<std::string> actuators;
  std::optional<Failure> of_another;
  for (const OfferedSkill& one : found.value()) {
    if (auto refused = meant.value()->Check(one.actuator)) {
      if (refused->exit != ExitCode::kNoController) return {false, std::move(refused)};
      const bool known = meant.value()->IsKnown(one.actuator);
      (known ? of_another : asked.failure) = std::move(refused);
      continue;
    }
    of_machine.push_back(one);
    actuators.push_back(one.actuator);
  }
  if (auto refused = meant.value()->CheckTogether(actuators)) return {false, std::move(refused)};
  for (const OfferedSkill& one : of_machine) {
    AskedRun answer = ask(one);
    if (auto* failure = std::get_if<Failure>(&answer)) {
      asked.failure = std::move(*failure);
    } else {
      asked.any = asked.any || std::get<bool>(answer);
    }
  }
  if (asked.any || asked.failure) return asked;
  if (actuators.empty() && of_another) {
    asked.failure = std::move(of_another);
  } else {
    asked.failure =
        Failure{ExitCode::kNotDone,
                {kCodeStateInvalid, skill + " is not running; offered by " + Joined(actuators)}};
  }
  return asked;
}

}  // namespace musher::cli
