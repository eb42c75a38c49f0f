#pragma once
// The last seconds of the odometry, to know where the body was when a picture was taken. Pure.
// Poses are in the odometry's frame: metres, yaw to the left. Stamps are those of the messages, in
// ns; pictures and odometry of a robot have the same clock. Any thread.

#include <cstdint>
#include <deque>
#include <optional>

#include "musher/base/time.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"

namespace musher::line_walker {

struct Pose {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};

struct Velocity {
  double forward_m_s = 0;
  double left_m_s = 0;
  double yaw_rad_s = 0;  // to the left

  friend bool operator==(const Velocity&, const Velocity&) = default;
};

// The angle in (-pi, pi].
double Wrapped(double angle_rad);

// The pose after moving so from `pose` for that time.
Pose Moved(const Pose& pose, const Velocity& velocity, double seconds);

class OdometryTrack {
 public:
  enum class Taken {
    kGood,
    kAgain,    // the stamp of the sample before: ignored
    kInvalid,  // NaN or no rotation: ignored
    kJump,     // farther than a body moves, or an earlier time: what was known is dropped
  };
  Taken Take(const msg::Odometry& odometry);

  bool empty() const { return samples_.empty(); }
  const Pose& pose() const { return samples_.back().pose; }  // the newest
  const Velocity& velocity() const { return samples_.back().velocity; }

  // --- not for an empty track ---

  // How long before the newest sample that stamp is, less than 0 after it; nothing: it is of
  // another clock, or none.
  std::optional<Duration> AgeOf(std::int64_t stamp_ns) const;
  // So long before the newest sample; before the oldest one, that.
  Pose At(Duration age) const;
  // Between the oldest sample and the newest.
  Duration span() const { return Duration(samples_.back().stamp_ns - samples_.front().stamp_ns); }

 private:
  struct Sample {
    std::int64_t stamp_ns = 0;
    Pose pose;
    Velocity velocity;
  };

  std::deque<Sample> samples_;
};

}  // namespace musher::line_walker
