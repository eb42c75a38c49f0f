#include "musher/modules/sensor/self_check.hpp"

#include <algorithm>
#include <string>

namespace musher::sensor {

Result<> JudgeSelfCheck(const std::vector<SensorFinding>& findings,
                        const std::vector<SensorKind>& critical) {
  Result<> verdict;
  std::string all;
  for (const SensorFinding& finding : findings) {
    if (finding.result) continue;
    const Error& error = finding.result.error();
    const std::string name(NameOf(finding.kind));
    const std::string code = ", " + std::to_string(error.code);
    if (std::find(critical.begin(), critical.end(), finding.kind) != critical.end()) {
      return Error{error.code, name + " (critical): " + error.message + code};
    }
    all += (all.empty() ? "" : "; ") + name + ": " + error.message + code;
    verdict = Error{verdict ? error.code : verdict.error().code, all};
  }
  return verdict;
}

}  // namespace musher::sensor
