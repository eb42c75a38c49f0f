#pragma once
// The skill land: a flyer descends to the ground below it.
//
//   INITIALIZING  2 s without odometry: fails
//   EXECUTING     descends at 0.5 m/s, and at 0.2 m/s within 0.5 m of the ground
//                 30 s, and as long as it still descends
//   MOVING_ASIDE  flies level to another place; descends where it has come to after 8 s
//
// It has landed when its height stands still for 1 s, within 0.3 m of the ground. A flyer that is
// held up in the air does not land: it hovers, and the skill fails at its limit. Above what its
// sensor sees below, higher than the ground, it waits 10 s, and fails with that; with the parameter
// `aside` it first tries the places around, 2 s at each, whose way its scan sees free. One that is
// carried off by wind, or was moved in a pause, lands where it is then. The height of the ground is
// absolute: metres above the zero of the map.

#include "musher/modules/skills/skills/flight_skill.hpp"

namespace musher::skills {

class Land : public FlightSkill {
 public:
  using FlightSkill::FlightSkill;

  void Declare(skill::Table& table) override;
  skill::Next OnLimit(skill::Tick& tick) override;

 private:
  skill::Next Fly(const navigation::Pose& now, skill::Tick& tick) override;
  bool KeepsItsPlace() const override { return false; }
  skill::Next GoAside(const navigation::Pose& now, skill::Tick& tick);
  // The next place; a failure where none is left.
  skill::Next Elsewhere(const navigation::Pose& now, skill::Tick& tick, std::string why);
  // Whether its scan covers the way to a place.
  bool SeesTowards(const navigation::Point& place, const navigation::Pose& now) const;
  bool IsFreeWay(const navigation::Point& from, const navigation::Point& to) const;

  skill::StateId initializing_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
  skill::StateId moving_aside_ = skill::kIdle;
};

}  // namespace musher::skills
