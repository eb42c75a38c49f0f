#include "musher/cli/commands/skill/skill_runs.hpp"

#include <utility>
#include <vector>

#include "musher/base/joined.hpp"
#include "musher/cli/machine/skill_offers.hpp"

namespace musher::cli {

AskedRuns AskRunsOf(Link& link, const GlobalOptions& global, const std::string& skill,
                    const std::string& actuator,
                    const std::function<AskedRun(const OfferedSkill& skill)>& ask) {
  const auto offers = SkillOffers::Begin(link, global);
  if (!offers) return {false, Failure{ExitCode::kUsage, offers.error()}};
  if (auto failure = offers.value()->Await(actuator)) return {false, std::move(failure)};
  const auto found = FindSkill(offers.value()->all(), skill, actuator);
  if (!found) return {false, Failure{ExitCode::kNotDone, found.error()}};
  AskedRuns asked;
  std::vector<std::string> actuators;
  for (const OfferedSkill& one : found.value()) {
    actuators.push_back(one.actuator);
    AskedRun answer = ask(one);
    if (auto* failure = std::get_if<Failure>(&answer)) {
      asked.failure = std::move(*failure);
    } else {
      asked.any = asked.any || std::get<bool>(answer);
    }
  }
  if (!asked.any && !asked.failure) {
    asked.failure =
        Failure{ExitCode::kNotDone,
                {kCodeStateInvalid, skill + " is not running; offered by " + Joined(actuators)}};
  }
  return asked;
}

}  // namespace musher::cli
