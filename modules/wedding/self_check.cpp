#include "musher/modules/wedding/self_check.hpp"

namespace musher::wedding {
namespace {

void Add(std::string& all, const char* name, const std::string& what) {
  all += (all.empty() ? "" : "; ") + std::string(name) + ": " + what;
}

}  // namespace

CheckVerdict EvaluateSelfCheck(const MissingParts& missing, const WeddingConfig& config) {
  std::string required;
  CheckVerdict verdict;
  const auto check = [&](Need need, const char* name, const std::string& what) {
    if (what.empty() || need == Need::kNone) return;
    Add(need == Need::kRequired ? required : verdict.missing, name, what);
  };
  check(config.camera, "camera", missing.camera);
  check(config.audio, "audio", missing.audio);
  check(config.motion, "motion", missing.motion);
  check(config.ready, "ready", missing.ready);
  if (!required.empty()) {
    verdict.result = Error{MakeCode(ModuleCode::kRobot, KeyCode::kSelfCheckFailed), required};
  }
  return verdict;
}

}  // namespace musher::wedding
