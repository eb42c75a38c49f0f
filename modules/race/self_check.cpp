#include "musher/modules/race/self_check.hpp"

namespace musher::race {

CheckVerdict EvaluateSelfCheck(const MissingParts& missing, const RobotRules& rules) {
  std::string required;
  CheckVerdict verdict;
  const auto check = [&](Need need, const char* name, const std::string& what) {
    if (what.empty() || need == Need::kNone) return;
    std::string& all = need == Need::kRequired ? required : verdict.missing;
    all += (all.empty() ? "" : "; ") + std::string(name) + ": " + what;
  };
  check(rules.motion, "motion", missing.motion);
  check(rules.cameras, "cameras", missing.cameras);
  check(rules.walker, "walker", missing.walker);
  check(rules.audio, "audio", missing.audio);
  if (!required.empty()) {
    verdict.result = Error{MakeCode(ModuleCode::kRobot, KeyCode::kSelfCheckFailed), required};
  }
  return verdict;
}

}  // namespace musher::race
