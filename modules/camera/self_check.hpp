#pragma once
// The outcome of the self-check from the results of all cameras. Pure.

#include <string>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::camera {

struct CameraResult {
  std::string camera;
  Result<> result;
};

// Fails when a critical camera fails, or when all checked cameras do: a robot that has lost one of
// three continues with two. The message names every failing camera, also on success, for the log.
struct SelfCheckVerdict {
  Result<> result;
  std::string failing;  // "left: no picture in 5000 ms, 4409; ..."
};
SelfCheckVerdict EvaluateSelfCheck(const std::vector<CameraResult>& checked,
                                   const std::vector<std::string>& critical);

}  // namespace musher::camera
