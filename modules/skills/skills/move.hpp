#pragma once
// Goes from way-point to way-point of a path, in a loop.
//
//   path     the way-points, m in the map: [[0, 0], [4, 0], [4, 3]]; for flyers with the height
//   loops    how often, 0: until it is cancelled (default)
//
// At a way-point the robot looks as it came. States, limits (120 s from one way-point to the next)
// and faults: goal_skill.hpp; there is no limit of the whole run. Details: those of navigate_to,
// waypoint and loop, both from 1 on.

#include "musher/modules/skills/skills/goal_skill.hpp"
#include "musher/modules/skills/skills/points_text.hpp"

namespace musher::skills {

class Move : public GoalSkill {
 public:
  using GoalSkill::GoalSkill;

 private:
  void Describe(skill::Table& table) override;
  Result<> Take(const skill::Tick& tick) override;
  navigation::Pose Goal(const skill::Tick& tick) const override;
  std::optional<std::string> OnArrival(skill::Tick& tick) override;
  std::string Prefix(const skill::Tick& tick) const override;
  double Share(skill::Tick& tick, double share) const override;

  Points path_;
  std::int64_t loops_ = 0;
};

}  // namespace musher::skills
