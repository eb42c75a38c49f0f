#pragma once
// The self-check's verdict over the cameras. Pure.

#include <string>
#include <vector>

#include "musher/lifecycle/result.hpp"

namespace musher::camera {

struct CameraFinding {
  std::string camera;
  Result<> result;
};

// Fails when a critical camera fails, or when all that were looked at do: a robot that has lost one
// of three goes on with two. The message names every failing camera; so does that of a success,
// for the log.
struct SelfCheckVerdict {
  Result<> result;
  std::string failing;  // "left: no picture in 5000 ms, 4409; ..."
};
SelfCheckVerdict EvaluateSelfCheck(const std::vector<CameraFinding>& findings,
                                   const std::vector<std::string>& critical);

}  // namespace musher::camera
