#pragma once
// The drive of a holonomic body to a pose: it waits for a pose, turns, drives, brakes. Pure: poses
// and the time are arguments.
//
//   idle ──Begin()──▶ waiting for a pose ──▶ yaw ──▶ xy ──▶ brake ──▶ idle, "Goal reached"
//    │                         │              │       │
//    └──Stop()──▶ brake        └──────────────┴───────┴─▶ brake ──▶ idle, with the reason
//
// - xy ends when the distance and the yaw are within their tolerances, both.
// - A failure and Stop() give their result at once, and zero velocities follow; a success gives it
//   after the zero velocities.
// - A pose counts until `pose_stale`; with an older one the drive fails, and so it does where poses
//   come later by more than that than the fastest one of the drive.
// - A drive fails where its poses cannot be true beside its velocities (motion_guard.hpp): they
//   stand while it drives, for `pose_stale`, or they jump. In a climb the body waits at the step.
//
// Metres, radians, seconds; poses in the map, velocities in the frame of the body. One thread. The
// defaults are those of the robot's own file.

#include <optional>
#include <string>

#include "musher/base/time.hpp"
#include "musher/modules/meilin/servers/pid.hpp"
#include "musher/navigation/gate/motion_guard.hpp"

namespace musher::meilin::servers {

struct MoveSettings {
  Duration period = Milliseconds(50);         // between updates of a drive
  Duration pose_wait = Milliseconds(2000);    // for the first pose of a drive
  Duration pose_stale = Milliseconds(500);    // an older pose ends a drive
  Duration yaw_limit = Milliseconds(10'000);  // of the yaw phase
  Duration xy_limit = Milliseconds(10'000);   // of the xy phase
  Duration brake_time = Milliseconds(300);    // of zero velocities
  double yaw_tolerance_deg = 1.0;
  double xy_tolerance_m = 0.015;
  double max_m_s = 1.5;
  double min_m_s = 0.15;
  double climb_m_s = 0;        // at most, while the suspension climbs; 0: as always
  double brake_m_s2 = 0;       // with which it slows down before the goal; 0: without a limit
  double max_yaw_rad_s = 1.5;  // in the yaw phase
  double min_yaw_rad_s = 0.2;
  double max_xy_yaw_rad_s = 0.4;  // in the xy phase
  PidGains yaw{1.5, 0.2, 0.05};
  PidGains xy_yaw{1.0, 0, 0};
  PidGains x{5.0, 0.01, 0.1};
  PidGains y{5.0, 0.01, 0.1};
  double integral_limit = 0.5;
};

struct FieldPose {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};

struct BodyVelocity {
  double x_m_s = 0;
  double y_m_s = 0;
  double yaw_rad_s = 0;

  friend bool operator==(const BodyVelocity&, const BodyVelocity&) = default;
};

enum class MovePhase { kIdle, kWaiting, kYaw, kXy, kBrake };
// "waiting_for_pose", "yaw", "xy", "brake", "idle".
const char* MovePhaseName(MovePhase phase);

// How a drive has ended.
struct MoveEnd {
  bool success = false;
  std::string message;
};

struct MoveFeedback {
  MovePhase phase = MovePhase::kIdle;
  FieldPose current;
  FieldPose target;
  double yaw_error_rad = 0;
  double distance_m = 0;
  BodyVelocity command;
};

class MoveToPose {
 public:
  explicit MoveToPose(const MoveSettings& settings);

  // Drives to `target`, also in the middle of another drive, whose result the caller has given.
  void Begin(const FieldPose& target, Time now);
  // A pose with a number that is not finite is ignored. `stamp`: of the message; 0: it has none.
  void OnPose(const FieldPose& pose, Time now, Duration stamp = {});
  void OnClimbing(bool climbing);
  // Poses of before do not count, as after a restart of the world.
  void ForgetPose();

  // The drive ends, if there is one: zero velocities follow.
  void Stop(Time now);
  // The text of a cancelled drive, by its phase.
  std::string CancelText() const;

  struct Step {
    std::optional<BodyVelocity> command;  // to be sent
    std::optional<MoveEnd> end;           // of the drive
    bool idle = false;                    // nothing more is to be sent
  };
  // To be called every UpdatePeriod().
  Step Update(Time now);
  Duration UpdatePeriod() const;

  MovePhase phase() const { return phase_; }
  const MoveFeedback& feedback() const { return feedback_; }
  // Why it knows no pose now; empty: it knows one.
  std::string Blind(Time now) const;

 private:
  Step Wait(Time now);
  Step Turn(Time now);
  Step Drive(Time now);
  Step Fail(const std::string& why, Time now);
  Step Guarded(const Step& step, Time now);
  std::string WhyNotTrue(Time now) const;
  bool Drives() const { return phase_ == MovePhase::kYaw || phase_ == MovePhase::kXy; }
  Step Send(const BodyVelocity& command);
  void Enter(MovePhase phase, Time now);
  void Measure();
  double TurnRate(double dt_s);
  double SecondsSinceLast(Time now);

  MoveSettings settings_;
  MovePhase phase_ = MovePhase::kIdle;
  Time since_;  // of the phase
  std::optional<Time> last_;
  std::optional<FieldPose> pose_;
  Time pose_at_;
  std::optional<Duration> fastest_;  // from a stamp to our time, in this drive
  Duration late_{};                  // the last pose, beyond that
  navigation::MotionGuard guard_;
  std::string fault_;  // that it has found in a pose; empty: none
  FieldPose target_;
  bool climbing_ = false;
  bool reached_ = false;  // the result follows after the brake
  MoveFeedback feedback_;
  Pid yaw_;
  Pid xy_yaw_;
  Pid x_;
  Pid y_;
};

// An angle in (-pi, pi].
double WrappedYaw(double yaw_rad);

}  // namespace musher::meilin::servers
