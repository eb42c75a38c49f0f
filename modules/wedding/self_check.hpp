#pragma once
// The self-check's verdict over the programs that the show needs. Plain values, no IO.

#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/modules/wedding/show_config.hpp"

namespace musher::wedding {

// Of each: nothing when it is well, else what is missing.
struct MissingParts {
  std::string camera;
  std::string audio;
  std::string motion;
  std::string ready;
};

struct CheckVerdict {
  Result<> result;      // names all that are required and missing
  std::string missing;  // of the optional ones, for the log; mostly nothing
};
CheckVerdict EvaluateSelfCheck(const MissingParts& findings, const WeddingConfig& config);

}  // namespace musher::wedding
