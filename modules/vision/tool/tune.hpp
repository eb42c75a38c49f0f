#pragma once
// musher-vision tune: the colours of a hall, the regions of things that stand or hang in it, and
// its white balance, from pictures of it that say in their names what a detector has to find.
//
//   front_lane-left-1.png     the detector front_lane has to say "left"
//   left-yes-bright.png       the detector left has to find something
//   red_barrier_detector-none-jacket.png     there is nothing to find
//
// What it says of a picture is right, missed (nothing, or a doubt) or wrong (something else, or
// something that is not there). A wrong word counts as much as kMissesOfAWrong missed ones. Of
// ranges that are equally good the middle is proposed, which is farthest from what fails. A white
// balance is proposed where regions and colours alone leave something missed or wrong. Lines keep
// their regions: their offsets and targets are shares of them.

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
  bool write = false;  // change [hall] of the file, else print it only
};

// Prints how well each detector does now, how well it does with the table [hall] that is proposed,
// this table, and which keys of detectors have to be removed for it. With `write` the file gets it,
// at once or not at all: its other lines stay, and each that is replaced is printed. Fails for a
// picture whose name has no detector of the config or no label of its kind, or that cannot be read,
// and where the file cannot be changed or written.
Result<> Tune(const VisionConfig& config, const TuneOptions& options, std::ostream& out);

}  // namespace musher::vision::tool
