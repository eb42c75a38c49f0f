#pragma once
// musher-vision look: what the detector of faces finds in a picture file. For tuning it.

#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/vision/vision_config.hpp"

namespace musher::vision::tool {

struct LookOptions {
  std::string file;  // of the module's config
  std::vector<std::string> pictures;
  std::string detector;            // of a course; empty: faces
  std::string out;                 // the picture with boxes; empty: none
  std::optional<double> hfov_deg;  // of the pictures; else the config's
  std::optional<double> at_m;      // known distance of the largest face
};

// Prints a line for each picture and each face. Fails with the first picture that cannot be read or
// written.
Result<> Look(const VisionConfig& config, const LookOptions& options, std::ostream& out);

}  // namespace musher::vision::tool
