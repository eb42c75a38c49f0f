#pragma once
// Keeps a flyer at its place while no skill and no drive moves it: after each end of a skill, in a
// pause and at a stop. A velocity of 0 does not: the wind carries it away. With a low battery it
// descends there instead, until it stands on the ground, also where no skill has moved it and it is
// found in the air: an empty one falls. Where it comes no lower far above the ground, on a roof or
// in an updraught, the descent goes on slowly until it is charged.
//
//   not needed ── used, low ──▶ armed ── not used, in the air, braked ──▶ holding, or descending
//        ▲                                                             │
//        └── landed, seen on the ground, or moved against its commands ◀───┘
//
// What is moved against its commands is in a hand, has been put down, or is another program's: it
// is never held again, and so climbs nowhere, until a skill or a drive moves it. That is one that
// comes kSunkM lower than its place, that is carried kLostM away, or that stands off its place
// while it is commanded back. With a low battery it descends also then: it only goes down.
//
// Metres; the frame of the odometry, with its zero on the ground. Pure; one thread.

#include <optional>
#include <string>

#include "musher/base/time.hpp"
#include "musher/modules/skills/robot/position_hold.hpp"

namespace musher::skills {

class FlightHold {
 public:
  static constexpr double kInTheAirM = 0.05;  // above the zero of the frame; a lower one stands
  static constexpr double kLostM = 1.5;       // off its place
  static constexpr double kSunkM = 0.2;       // below its place
  static constexpr double kDescentMps = 0.5;
  static constexpr double kLastDescentMps = 0.2;  // near the ground, and without a height

  // A skill or a drive moves it.
  void Use();
  // It stands on the ground: it is not held there.
  void Land();
  // Another program has commanded it: it is that program's. With a low battery it still descends.
  void Yield();
  // From now on it descends, or no more; a repetition changes nothing.
  void SetBatteryLow(bool low);
  // Its battery is charged: one that stands high is not held there.
  void NoteCharging();
  // The last command did not reach the body, so that it does not move shows nothing.
  void NoteStopped();
  // It descends and comes no lower, far above the ground.
  bool StandsHigh() const;
  // Why it is no longer held since Use(): "it came 0.21 m lower …". Empty: it is held, or landed.
  const std::string& ended() const { return ended_; }

  // The command, in the frame of the body, `step` after the last one; nullopt: none is needed.
  // Without a pose it is 0, and with a low battery down, unless it stood on the ground.
  // `speed_m_s`: of the body.
  std::optional<navigation::Velocity> Command(const std::optional<navigation::Pose>& pose,
                                              double speed_m_s, Duration step);

 private:
  std::optional<navigation::Velocity> Descend(const navigation::Pose& pose, Duration step);
  // Why a body at `pose` is moved by something else than its commands; empty: it is not.
  std::string MovedAgainstCommands(const navigation::Pose& pose, Duration step);
  void End(std::string why);

  PositionHold hold_;
  bool armed_ = false;
  bool landed_ = false;  // and no skill or drive has moved it since then
  bool low_ = false;
  bool arms_ = false;  // if the next pose is in the air
  Duration braking_{};
  Duration still_{};  // how long it has not come lower
  double lowest_m_ = 0;
  std::optional<navigation::Pose> place_;
  navigation::Point unmoved_at_;  // off its place it has not left here
  Duration unmoved_{};            // for so long
  std::string ended_;
};

}  // namespace musher::skills
