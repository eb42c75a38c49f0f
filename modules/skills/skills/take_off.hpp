#pragma once
// The skill take_off: a flyer climbs to a height and hovers there.
//
//   INITIALIZING  checks the altitude and the start        2 s without odometry: fails
//   EXECUTING     climbs at 0.5 m/s above its start        30 s; done at most 0.1 m below
//
// The altitude is absolute: metres above the zero of the map. A flyer that is in the air already
// climbs from there; one that is higher than the altitude refuses, since taking off never descends.
// Below 0.3 m it may stand, whatever its odometry says: there it has to rise by half of the way.

#include "musher/modules/skills/skills/flight_skill.hpp"

namespace musher::skills {

class TakeOff : public FlightSkill {
 public:
  using FlightSkill::FlightSkill;

  void Declare(skill::Table& table) override;
  skill::Next OnLimit(skill::Tick& tick) override;

 private:
  skill::Next Fly(const navigation::Pose& now, skill::Tick& tick) override;
  skill::Next Check(const navigation::Pose& now, skill::Tick& tick);

  skill::StateId initializing_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
};

}  // namespace musher::skills
