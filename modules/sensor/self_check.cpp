#include "musher/modules/sensor/self_check.hpp"

#include <algorithm>
#include <string>

namespace musher::sensor {

SelfCheckVerdict EvaluateSelfCheck(const std::vector<SensorResult>& checked,
                                   const std::vector<SensorKind>& critical) {
  SelfCheckVerdict verdict;
  Error& degraded = verdict.degraded;
  for (const SensorResult& one : checked) {
    if (one.result) continue;
    const Error& error = one.result.error();
    const std::string name(NameOf(one.kind));
    const std::string code = ", " + std::to_string(error.code);
    if (std::find(critical.begin(), critical.end(), one.kind) != critical.end()) {
      return {Error{error.code, name + " (critical): " + error.message + code}};
    }
    if (degraded.code == kCodeOk) degraded.code = error.code;
    degraded.message += (degraded.message.empty() ? "" : "; ") + name + ": " + error.message + code;
  }
  return verdict;
}

}  // namespace musher::sensor
