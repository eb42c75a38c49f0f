#include "musher/modules/device/self_check.hpp"

#include <algorithm>

namespace musher::device {

SelfCheckVerdict EvaluateSelfCheck(const std::vector<DeviceResult>& checked,
                                   const std::vector<std::string>& critical) {
  const auto is_critical = [&](const DeviceResult& one) {
    return std::find(critical.begin(), critical.end(), one.device) != critical.end();
  };
  const DeviceResult* worst = nullptr;
  std::string message;
  for (const DeviceResult& one : checked) {
    if (one.result) continue;
    if (worst == nullptr || (is_critical(one) && !is_critical(*worst))) worst = &one;
    if (!message.empty()) message += "; ";
    message += one.device + (is_critical(one) ? " (critical): " : ": ") +
               one.result.error().message + ", " + std::to_string(one.result.error().code);
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
