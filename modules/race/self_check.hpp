#pragma once
// The outcome of the self-check from the programs that the race needs. Plain values, no IO.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/race/course.hpp"

namespace musher::race {

// For each program: empty when it is available, else what is missing.
struct MissingParts {
  std::string motion;
  std::string cameras;
  std::string walker;
  std::string audio;
};

struct CheckVerdict {
  Result<> result;      // names all that are required and missing
  std::string missing;  // of the optional ones, for the log; usually empty
};
CheckVerdict EvaluateSelfCheck(const MissingParts& missing, const RobotRules& rules);

}  // namespace musher::race
