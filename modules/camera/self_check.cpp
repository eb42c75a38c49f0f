#include "musher/modules/camera/self_check.hpp"

#include <algorithm>
#include <cstddef>

#include "musher/modules/camera/camera_code.hpp"

namespace musher::camera {

SelfCheckVerdict EvaluateSelfCheck(const std::vector<CameraResult>& checked,
                                   const std::vector<std::string>& critical) {
  SelfCheckVerdict verdict;
  std::size_t failed = 0;
  bool critical_failed = false;
  for (const CameraResult& one : checked) {
    if (one.result) continue;
    ++failed;
    const bool is_critical =
        std::find(critical.begin(), critical.end(), one.camera) != critical.end();
    critical_failed = critical_failed || is_critical;
    if (!verdict.failing.empty()) verdict.failing += "; ";
    verdict.failing += one.camera + (is_critical ? " (critical): " : ": ") +
                       one.result.error().message + ", " + std::to_string(one.result.error().code);
  }
  if (critical_failed || (failed > 0 && failed == checked.size())) {
    constexpr std::int32_t kCode = CameraCode(KeyCode::kSelfCheckFailed);
    verdict.result = Error{kCode, verdict.failing};
  }
  return verdict;
}

}  // namespace musher::camera
