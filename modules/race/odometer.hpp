#pragma once
// How far the body has come during a walk, by its odometry. Pure.
//
// It is not believed while no new sample comes for OdometryRules::fresh, nor for the rest of a walk
// in which it jumps farther than a body can move. A sample that is old, or has the stamp of the one
// before, is not a new one. One with exactly the pose of the one before is new, and shows nothing.
//
// Times are those of the machine, which stands still in a pause. One thread.

#include <cstdint>
#include <optional>
#include <string>

#include "musher/modules/race/course.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::race {

// In the frame of the body, see course.hpp.
struct Displacement {
  double forward_m = 0;
  double left_m = 0;
  double yaw_rad = 0;
};

class Odometer {
 public:
  explicit Odometer(const OdometryRules& rules) : rules_(rules) {}

  // A walk begins or continues. What was received before does not count.
  void Begin(Duration now);
  // A finite pose; `age` at its reception. Samples between two walks are to be left out.
  void OnSample(std::int64_t stamp_ns, const navigation::Pose& pose, Duration age);

  // Each tick of a walk: the displacement since the last tick with a new sample; nothing without
  // one.
  std::optional<Displacement> Take(Duration now);
  bool believed() const { return doubt_.empty(); }
  // How long its new samples have had the pose of the one before, OdometryRules::begin left out.
  Duration still() const { return still_at_ - still_from_; }
  // Why it is not believed; empty: it is.
  const std::string& doubt() const { return doubt_; }

 private:
  std::string WhySilent() const;

  const OdometryRules& rules_;
  std::optional<navigation::Pose> pose_;  // the newest of this walk; none after a gap
  std::optional<std::int64_t> stamp_ns_;  // of the newest sample of this walk
  std::int64_t pose_stamp_ns_ = 0;        // of the first sample with the pose
  Displacement moved_;                    // since the last tick with a new sample
  bool is_new_ = false;                   // a sample since the last tick
  Duration received_at_{};
  bool frozen_ = false;    // the last sample had the stamp of the one before
  bool is_still_ = false;  // a sample with a pose of before, since the last tick
  Duration still_from_{};
  Duration still_at_{};           // the last of such samples
  std::optional<Duration> late_;  // the age of the last sample, where it was old
  std::string jump_;              // in this walk
  std::string doubt_;
};

}  // namespace musher::race
