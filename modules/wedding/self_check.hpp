#pragma once
// The outcome of the self-check from the programs that the show needs. Plain values, no IO.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/wedding/show_config.hpp"

namespace musher::wedding {

// For each program: empty when it is available, else what is missing.
struct MissingParts {
  std::string camera;
  std::string audio;
  std::string motion;
  std::string ready;
};

struct CheckVerdict {
  Result<> result;      // names all that are required and missing
  std::string missing;  // of the optional ones, for the log; usually empty
};
CheckVerdict EvaluateSelfCheck(const MissingParts& missing, const WeddingConfig& config);

}  // namespace musher::wedding
