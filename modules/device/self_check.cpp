#include "musher/modules/device/self_check.hpp"

#include <algorithm>

namespace musher::device {

SelfCheckVerdict EvaluateSelfCheck(const std::vector<DeviceFinding>& findings,
                                   const std::vector<std::string>& critical) {
  const auto is_critical = [&](const DeviceFinding& finding) {
    return std::find(critical.begin(), critical.end(), finding.device) != critical.end();
  };
  const DeviceFinding* worst = nullptr;
  std::string message;
  for (const DeviceFinding& finding : findings) {
    if (finding.result) continue;
    if (worst == nullptr || (is_critical(finding) && !is_critical(*worst))) worst = &finding;
    if (!message.empty()) message += "; ";
    message += finding.device + (is_critical(finding) ? " (critical): " : ": ") +
               finding.result.error().message + ", " + std::to_string(finding.result.error().code);
  }
  SelfCheckVerdict verdict;
  if (worst == nullptr) return verdict;
  const Error error{worst->result.error().code, message};
  if (is_critical(*worst)) {
    verdict.result = error;
  } else {
    verdict.degraded = error;
  }
  return verdict;
}

}  // namespace musher::device
