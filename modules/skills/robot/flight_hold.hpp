#pragma once
// Keeps a flyer at its place while no skill and no drive moves it: after each end of a skill, in a
// pause and at a stop. A velocity of 0 does not: the wind carries it away. With a low battery it
// descends there instead, until it stands on the ground, also where no skill has moved it and it is
// found in the air: an empty one falls. Where it comes no lower far above the ground, on a roof or
// in an updraught, the descent goes on slowly until it is charged.
//
//   not needed ── used, low ──▶ armed ── not used, in the air, braked ──▶ holding, or descending
//        ▲                                                             │
//        └── landed, or carried farther than kLostM: another process moves it ◀┘
//
// Metres; the frame of the odometry, with its zero on the ground. Pure; one thread.

#include <optional>

#include "musher/base/time.hpp"
#include "musher/modules/skills/robot/position_hold.hpp"

namespace musher::skills {

class FlightHold {
 public:
  static constexpr double kInTheAirM = 0.05;  // above the zero of the frame; a lower one stands
  static constexpr double kLostM = 1.5;
  static constexpr double kDescentMps = 0.5;
  static constexpr double kLastDescentMps = 0.2;  // near the ground, and without a height

  // A skill or a drive moves it.
  void Use();
  // It stands on the ground: it is not held there.
  void Land();
  // From now on it descends, or no more; a repetition changes nothing.
  void SetBatteryLow(bool low);
  // Its battery is charged: one that stands high is not held there.
  void NoteCharging();
  // The last command did not reach the body, so that it comes no lower shows nothing.
  void NoteStopped();
  // It descends and comes no lower, far above the ground.
  bool StandsHigh() const;

  // The command, in the frame of the body, `step` after the last one; nullopt: none is needed.
  // Without a pose it is 0, and with a low battery down, unless it stood on the ground.
  // `speed_m_s`: of the body.
  std::optional<navigation::Velocity> Command(const std::optional<navigation::Pose>& pose,
                                              double speed_m_s, Duration step);

 private:
  std::optional<navigation::Velocity> Descend(const navigation::Pose& pose, Duration step);

  PositionHold hold_;
  bool armed_ = false;
  bool landed_ = false;  // and no skill or drive has moved it since then
  bool low_ = false;
  bool arms_ = false;    // if the next pose is in the air
  bool stands_ = false;  // on the ground, by the last pose, and has not flown since Use()
  Duration braking_{};
  Duration still_{};  // how long it has not come lower
  double lowest_m_ = 0;
  std::optional<navigation::Pose> place_;
};

}  // namespace musher::skills
