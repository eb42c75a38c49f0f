#include "musher/modules/wedding/self_check.hpp"

namespace musher::wedding {
namespace {

void Add(std::string& all, const char* name, const std::string& what) {
  all += (all.empty() ? "" : "; ") + std::string(name) + ": " + what;
}

}  // namespace

CheckVerdict EvaluateSelfCheck(const MissingParts& findings, const WeddingConfig& config) {
  std::string required;
  CheckVerdict verdict;
  const auto judge = [&](Need need, const char* name, const std::string& what) {
    if (what.empty() || need == Need::kNone) return;
    Add(need == Need::kRequired ? required : verdict.missing, name, what);
  };
  judge(config.camera, "camera", findings.camera);
  judge(config.audio, "audio", findings.audio);
  judge(config.motion, "motion", findings.motion);
  judge(config.ready, "ready", findings.ready);
  if (!required.empty()) {
    verdict.result = Error{MakeCode(ModuleCode::kRobot, KeyCode::kSelfCheckFailed), required};
  }
  return verdict;
}

}  // namespace musher::wedding
