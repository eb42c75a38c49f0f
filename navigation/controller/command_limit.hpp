#pragma once
// Keeps the change from one velocity command of a body to the next within its accelerations, also
// where the control corrects an error, a path is replaced, or the gate lets the body go on.
//
//   wanted ──▶ BeforeGate() ──▶ the gate ──▶ AfterGate() ──▶ the body
//
// The gate may slow a command down as hard as it has to. Changes are compared in the frame of the
// map, since the frame of the body turns; those of a body that only drives ahead in its own frame.
//
// Metres, radians, seconds. Pure; one thread.

#include "musher/base/time.hpp"
#include "musher/navigation/pose.hpp"
#include "musher/navigation/trajectory/speed_profile.hpp"

namespace musher::navigation {

class CommandLimit {
 public:
  // `ahead`: the body only drives ahead and turns.
  CommandLimit(const MotionLimits& limits, bool ahead) : limits_(limits), ahead_(ahead) {}

  // The body stands.
  void Begin(Time now);

  // The command that may follow, in the frame of the body with that yaw. `brakes`: for an obstacle,
  // as hard as it is wanted.
  Velocity BeforeGate(const Velocity& wanted, double yaw_rad, Time now, bool brakes);
  // What may be sent of the command that the gate lets pass.
  Velocity AfterGate(const Velocity& passed, double yaw_rad);
  // What was sent last is so slow that 0 may follow.
  bool IsAtRest() const;

 private:
  double FrameYaw(double yaw_rad) const { return ahead_ ? 0 : yaw_rad; }

  const MotionLimits limits_;
  const bool ahead_;
  Time at_{};
  double step_s_ = 0;
  Velocity wanted_;  // the last one before the gate
  Velocity sent_;    // the last one after it
};

}  // namespace musher::navigation
