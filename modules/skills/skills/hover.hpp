#pragma once
// The skill hover: a flyer goes to a height, if one is given, and holds its place there against
// wind for a duration.
//
//   INITIALIZING  checks altitude, duration and that it flies   2 s without odometry: fails
//                 brakes, for at most 1 s, before it takes its place
//   APPROACHING   climbs or descends at up to 0.5 m/s           30 s; 10 s above what is below
//   HOVERING      holds the place; the time within 0.1 m of the height counts
//                 30 s longer than the duration: fails
//
// The altitude is absolute: metres above the zero of the map. 0: the height where it is. Times are
// run time, so a slow simulation hovers as long as a fast one, and a pause does not count.

#include "musher/modules/skills/skills/flight_skill.hpp"

namespace musher::skills {

class Hover : public FlightSkill {
 public:
  using FlightSkill::FlightSkill;

  void Declare(skill::Table& table) override;
  skill::Next OnLimit(skill::Tick& tick) override;
  // The flyer has to be in the air, and not in a hand.
  Result<> MayResume() override;

 private:
  skill::Next Fly(const navigation::Pose& now, skill::Tick& tick) override;
  skill::Next Check(const navigation::Pose& now, skill::Tick& tick);
  skill::Next Approach(const navigation::Pose& now, skill::Tick& tick);
  skill::Next Hold(const navigation::Pose& now, skill::Tick& tick);

  skill::StateId initializing_ = skill::kIdle;
  skill::StateId approaching_ = skill::kIdle;
  skill::StateId hovering_ = skill::kIdle;
};

}  // namespace musher::skills
