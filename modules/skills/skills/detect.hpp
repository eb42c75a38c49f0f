#pragma once
// The skill detect: where a certain object is, by its name or category, however far away.
//
//   EXECUTING     waits for objects and for odometry    5 s: fails
//
// Fails for a target that is not among the objects, with those that there are. Details: those of
// object_detection.

#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

class Detect : public skill::Skill {
 public:
  explicit Detect(Robot& robot) : robot_(robot) {}

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;

 private:
  Robot& robot_;
};

}  // namespace musher::skills
