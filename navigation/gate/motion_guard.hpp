#pragma once
// Compares what is sent to a body with what its odometry says. A drive ends, with the reason, when
// the two cannot both be true:
//
//   kJump    the pose has jumped farther than the body can have moved
//   kStuck   commanded but not moving: a thing below the scanner, wheels that slip, odometry that
//            stands although it is fresh
//   kPushed  moving but not commanded: a body that is carried or pushed
//
// Small corrections of a localisation are no jump. Messages that were held up come at once: then
// their stamps say how much time has passed, but never more than since the earlier one was taken,
// by the time at which it came.
//
// Velocities in the frame of the body, poses of one frame. Pure; one thread.

#include <deque>
#include <optional>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/navigation/gate/sample_age.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation {

struct GuardRules {
  double speed_m_s = 1.5;  // of the body, at most
  double yaw_rad_s = 1.0;
  double jump_m = 0.5;  // more than it can have moved is a jump
  double jump_rad = 0.8;
  Duration stuck = std::chrono::seconds(3);   // commanded without moving
  Duration frozen = std::chrono::seconds(1);  // commanded, and its pose does not change at all
  bool drifts = false;                        // moves without a command: a flyer in the wind
};

class MotionGuard {
 public:
  explicit MotionGuard(const GuardRules& rules) : rules_(rules) {}

  // At the begin of a drive.
  void Restart();
  void Restart(const GuardRules& rules) {
    rules_ = rules;
    Restart();
  }
  // Poses of before are not compared: the time was set.
  void Forget();

  // `stamp`: of the message; 0: it has none.
  std::optional<Error> OnPose(const Pose& pose, Duration stamp, Time now);
  // What is sent to the body now.
  std::optional<Error> OnCommand(const Velocity& sent, Time now);

 private:
  struct Seen {
    Pose pose;
    Time taken{};  // by its stamp, in our time; as the one before if that says nothing
    Time at{};
  };

  // What was commanded while the pose has shown no motion.
  struct Commanded {
    double way_m = 0;
    double turn_rad = 0;
    double driven_s = 0;

    bool IsEnough() const;  // to see whether it moves
    void Add(const Velocity& velocity, double seconds);
  };

  std::optional<Error> Jump(const Seen& from, const Seen& to) const;
  std::optional<Error> Stuck(double seconds, Time now);
  std::optional<Error> Pushed(Time now);

  GuardRules rules_;
  SampleAge age_;
  std::optional<Time> taken_;   // the last one, by its stamp
  std::deque<Seen> seen_;       // of the last half second
  std::optional<Pose> anchor_;  // where it has last moved on from
  Commanded since_anchor_;
  Commanded since_change_;  // of any number of the pose
  Velocity sent_;
  std::optional<Time> sent_at_;
  std::optional<Time> resting_since_;
  std::optional<Pose> rest_;  // where it has come to rest
};

}  // namespace musher::navigation
