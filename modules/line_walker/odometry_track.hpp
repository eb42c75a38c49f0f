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
    kInvalid,  // NaN or no rotation: ignored
    kJump,     // another place or an earlier time than before: what was known is dropped
  };
  Taken Take(const msg::Odometry& odometry);

  bool empty() const { return samples_.empty(); }
  const Pose& pose() const { return samples_.back().pose; }  // the newest
  const Velocity& velocity() const { return samples_.back().velocity; }

  // At that stamp, or `otherwise` before the newest sample where the stamp is of another clock. Not
  // for an empty track.
  Pose At(std::int64_t stamp_ns, Duration otherwise) const;

 private:
  struct Sample {
    std::int64_t stamp_ns = 0;
    Pose pose;
    Velocity velocity;
  };

  std::deque<Sample> samples_;
};

}  // namespace musher::line_walker
