#pragma once
// The detectors of the race: which of them are needed, and the newest picture of each. Pure.
//
// Times: `now` is that of the machine, which stands still in a pause; a picture has the time at
// which it was taken, of the actuator's clock. One thread.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/race/outputs.hpp"

namespace musher::race {

// What a detector has found in a picture, as of musher_msgs/Sighting; of a detector of words its
// text alone.
struct Sighting {
  bool seen = false;
  double distance_m = 0;  // NaN: not known
  std::string phase;
  std::string text;
  double offset = 0;      // of its middle from that of the picture, -0.5 to 0.5 of the width
  double confidence = 0;  // 0.5 to 1 of what is seen; 0: nothing is, or not known
};

// The yellow lines of a picture, as of musher_msgs/YellowLines.
struct Lines {
  std::uint32_t contours = 0;  // 0: no line is seen
  LineWord ycy = LineWord::kCenter;
  LineWord dy = LineWord::kCenter;
  double middle_offset = 0;  // of their middle from its place, as a share of the width; NaN: none
  std::string doubt{};       // why the words mean nothing; empty: they do
};

class Perception {
 public:
  Perception(const Course& course, RaceOutputs& outputs)
      : course_(course),
        outputs_(outputs),
        watched_(course.detectors.size()),
        open_(course.detectors.size()) {}

  // Samples of a detector that is not needed are ignored. `taken` by the picture's stamp, which may
  // be ahead of `time`: then the picture counts as one of now.
  void OnSighting(Index detector, Sighting sighting, Time taken, Time time);
  void OnLines(Index detector, const Lines& lines, Time taken, Time time);
  // A picture of it says nothing, for that reason. It counts as none.
  void OnDoubt(Index detector, std::string why);

  // --- each tick ---

  void BeginTick();
  // The detector is needed in this tick.
  void Want(Index detector) { watched_[detector].wanted = true; }
  // The newest sample that was taken at `after` or later; null: none.
  const Sighting* SightingSince(Index detector, Time after) const;
  const Lines* LinesSince(Index detector, Time after) const;
  // The number of its pictures so far: another one for each new picture.
  std::uint64_t Pictures(Index detector) const { return watched_[detector].pictures; }
  // A sample has come since it was opened, of whichever age.
  bool HasStarted(Index detector) const { return watched_[detector].taken.has_value(); }
  // Opens and closes detectors. Returns one that has been silent for too long: a sample with the
  // time of the one before, or one that is so old itself, does not count. `time` is that of the
  // actuator's clock.
  std::optional<Index> EndTick(Duration now, Time time);
  // The reason of the last picture in doubt since its last sample; empty: none is known.
  const std::string& DoubtOf(Index detector) const { return watched_[detector].doubt; }

  // None is needed any more.
  void Close();

 private:
  struct Watched {
    bool wanted = false;
    bool received = false;  // a new sample since the last tick
    Duration received_at{};
    std::optional<Time> stamped;  // of the newest sample
    std::optional<Time> taken;    // the same, but not in the future
    std::uint64_t pictures = 0;
    Sighting sighting;
    Lines lines;
    std::string doubt;
  };

  bool Takes(Index detector, Detector::Kind kind, Time taken, Time time);

  const Course& course_;
  RaceOutputs& outputs_;
  std::vector<Watched> watched_;  // by detector
  std::vector<bool> open_;
};

}  // namespace musher::race
