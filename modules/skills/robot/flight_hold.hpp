#pragma once
// Keeps a flyer at its place while no skill and no drive moves it: after each end of a skill, in a
// pause and at a stop. A velocity of 0 does not: the wind carries it away.
//
//   not needed ── used ──▶ armed ── not used, in the air, braked ──▶ holding
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

  // A skill or a drive moves it.
  void Use();
  // It stands on the ground: it is not held there.
  void Land() { armed_ = false; }

  // The command, in the frame of the body, `step` after the last one; nullopt: none is needed.
  // Without a pose it is 0. `speed_m_s`: of the body.
  std::optional<navigation::Velocity> Command(const std::optional<navigation::Pose>& pose,
                                              double speed_m_s, Duration step);

 private:
  PositionHold hold_;
  bool armed_ = false;
  Duration braking_{};
  std::optional<navigation::Pose> place_;
};

}  // namespace musher::skills
