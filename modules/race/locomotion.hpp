#pragma once
// The robot's body during a race: walks as servo streams, and motions with an end. Pure.
//
//   a walk     a frame each tick, then one frame with `end`: exactly one for each stream
//   a motion   its pause before, the call, its reply, its pause after
//
// With odometry a walk ends where the body has come as far as it was to walk, within shares of its
// time (OdometryRules); without, or while it is not believed, by its time.
//
// A pause ends the stream; the walk continues with what is left of it. A motion that failed in a
// pause, or less than kStopGrace before it, is repeated. Before anything continues the robot stands
// up, unless it was lying; and before a walk where it is lying, because a command has led there, or
// may be since a pause in which nothing was under way.
//
// Times are those of the machine, which stands still in a pause. One thread.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/result.hpp"
#include "musher/modules/race/odometer.hpp"
#include "musher/modules/race/outputs.hpp"

namespace musher::race {

// A walk, and how much of it is done. Distances are in time at the speed of the movement.
struct WalkProgress {
  Index movement = 0;
  Duration length{};
  Duration limit{};       // of `walked`
  Duration walked{};      // how long it has lasted so far
  Duration measured{};    // by odometry where that is believed, else by time
  Duration made{};        // the same within the bounds of OdometryRules
  double turned_rad = 0;  // by odometry, to the left

  Duration left() const { return length - made; }
};

class Locomotion {
 public:
  Locomotion(const Course& course, RaceOutputs& outputs)
      : course_(course), outputs_(outputs), odometer_(course.odometry) {}

  void Walk(const Stretch& stretch);
  // The same, but also by time it is no longer.
  void WalkAtMost(const Stretch& stretch);
  void Continue(const WalkProgress& walk);
  void Move(Index movement, Duration now);

  // Turns the present walk beside its twist, until the next call or walk. Left is positive.
  void Steer(double yaw_rad_s) { steer_rad_s_ = yaw_rad_s; }

  // Once a tick while a walk or a motion is under way. Returns true when it has ended. `time` is
  // that of the actuator's clock.
  bool Advance(Duration now, Time time);
  // Ends a walk early and drops a motion whose call may still be under way.
  WalkProgress Stop();
  // The same; pictures of a check have to be newer than this.
  WalkProgress Halt(Time time) {
    walked_until_ = time;
    return Stop();
  }

  // The walk stands still until the next Advance().
  void Wait() { EndStream(); }

  bool walking() const { return walk_.has_value(); }
  const std::optional<WalkProgress>& walk() const { return walk_; }
  // The last walk that has come to its end.
  const WalkProgress& ended_walk() const { return ended_walk_; }
  // Frames are sent: odometry counts.
  bool streaming() const { return streaming_; }
  // Why the present or last walk goes by its time and not by odometry; empty: it does not.
  const std::string& doubt() const { return odometer_.doubt(); }
  // Once: that a walk has ended at a bound of OdometryRules, with the distances.
  std::optional<std::string> TakeDifference() { return std::exchange(difference_, std::nullopt); }
  // Whether the walk leads ahead.
  bool ahead() const;
  // When the last walk ended.
  Time walked_until() const { return walked_until_; }
  // A motion was called and has not been answered.
  bool busy() const { return call_.has_value(); }
  // Gives up an unanswered call after its limit. To be called also while nothing else is under way.
  void ExpireCall(Duration now);

  void Pause();
  // `stand`: it was under way, and has to stand again.
  void Resume(bool stand, Duration now);
  bool standing_up() const { return stands_.has_value(); }
  // A lying robot stands up before it does what is next: for walks of others. Returns whether it
  // does.
  bool Rise(Duration now);
  // Once a tick before anything else; returns true when it stands.
  bool AdvanceStanding(Duration now);

  // --- what the body reports ---

  void OnMotionDone(std::uint64_t number, const Result<>& done);
  // The switch_status and motion_id of motion_status.
  void OnBody(int switch_status, int motion_id);
  // motion_servo_response.
  void OnServoReply(bool accepted, std::int32_t code);
  // See Odometer::OnSample().
  void OnOdometry(std::int64_t stamp_ns, const navigation::Pose& pose, Duration age) {
    if (streaming_) odometer_.OnSample(stamp_ns, pose, age);
  }

  // A run begins: what the feet did before it does not count.
  void ForgetSlip() { ways_ = {}; }
  // "0.91 of its way ahead, 0.88 aside": what odometry has shown so far; empty: not enough of it.
  std::string SlipText() const;

  // Why it cannot go on: once, with the text. Evaluated each tick in which the body is in use.
  std::optional<std::string> Fault(Duration now);

 private:
  enum class Stage : std::uint8_t { kBefore, kCall, kReply, kAfter, kFailed };
  struct Motion {
    Index movement = 0;
    Stage stage = Stage::kBefore;
    Duration since{};        // of the stage
    std::uint64_t call = 0;  // its number
    std::string why;         // it failed
  };
  struct Call {
    std::uint64_t number = 0;
    Duration limit{};
    Duration since{};
    Index movement = 0;
    bool paused = false;  // a pause has come between: a failure is repeated
  };

  // The ways of which the feet slip differently.
  enum class Way : std::uint8_t { kAhead, kAside, kTurn };
  struct WaySums {
    Duration walked{};
    Duration measured{};
  };

  static Way WayOf(const Twist& twist);
  // How much of the usual way odometry has shown: 1 where it has not shown enough.
  double ShareOf(Way way) const;
  // What time alone counts: it slips as the walks before.
  Duration ByTime(Duration time) const;
  bool AdvanceMotion(Motion& motion, Duration now);
  void StandFirst(Duration now);
  bool AdvanceWalk(Duration now, Time time);
  // Counts the time since the last frame, or what odometry shows.
  void CountProgress(Duration now);
  void Measure(Duration distance);
  // A walk that comes far less far than its time is stopped by something.
  void FailIfBlocked(const Movement& movement);
  // A straight walk that turns too far has lost its way.
  void CountTurn(double yaw_rad);
  // Where odometry and time differ too much.
  void CompareWithTime(const WalkProgress& walk);
  void EndStream();
  void Send(bool end);
  void Fail(const std::string& why) {
    if (!fault_) fault_ = why;
  }

  const Course& course_;
  RaceOutputs& outputs_;
  Odometer odometer_;
  std::optional<WalkProgress> walk_;
  WalkProgress ended_walk_;
  Duration unmeasured_{};  // of the walk, since the last sample of odometry
  std::optional<std::string> difference_;
  std::array<WaySums, 3> ways_;  // by Way, the older the less
  double steer_rad_s_ = 0;
  bool streaming_ = false;
  Duration frame_at_{};  // of the last frame
  Duration stream_from_{};
  Time walked_until_{};
  std::optional<Motion> motion_;
  std::optional<Motion> stands_;
  std::optional<Call> call_;
  std::uint64_t calls_ = 0;
  bool lying_ = true;
  bool paused_ = false;
  bool stands_again_ = false;  // after the last pause
  std::optional<std::string> fault_;
  // The body.
  int bad_reports_ = 0;  // in a row
  std::string bad_;
  bool body_received_ = false;  // since the last tick
  Duration body_received_at_{};
  bool refused_ = false;  // the last servo reply
  std::optional<Duration> refused_from_;
  std::int32_t refused_code_ = 0;
};

}  // namespace musher::race
