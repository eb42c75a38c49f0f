#pragma once
// musher-vision tune: the colours of a hall, from pictures of it that say in their names what a
// detector has to find.
//
//   front_lane-left-1.png     the detector front_lane has to say "left"
//   left-yes-bright.png       the detector left has to find something
//   red_barrier_detector-none-jacket.png     there is nothing to find
//
// What it says of a picture is right, missed (nothing, or a doubt) or wrong (something else, or
// something that is not there). A wrong word counts as much as kMissesOfAWrong missed ones. Of
// ranges that are equally good the middle is proposed, which is farthest from what fails.

#include <ostream>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/vision/vision_config.hpp"

namespace musher::vision::tool {

inline constexpr int kMissesOfAWrong = 4;

struct TuneOptions {
  std::string file;    // of the module's config
  std::string folder;  // of the pictures
};

// Prints how well each detector does now, the colours that do better, how well it does with them,
// the table [hall] with them, and which colours of detectors have to be removed for it. Fails for a
// picture whose name has no detector of the config or no label of its kind, or that cannot be read.
Result<> Tune(const VisionConfig& config, const TuneOptions& options, std::ostream& out);

}  // namespace musher::vision::tool
