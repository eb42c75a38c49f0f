#pragma once
// The skill object_detection: what of a class is in the view of a camera of the robot.
//
//   INITIALIZING  checks the camera
//   EXECUTING     waits for objects and for odometry    5 s: fails
//
// The view: objects within `radius` of the robot, and within `angle` around straight on. It
// completes also when it has found none: that is what it has observed. Details: count, names, and
// of the nearest one name, position (m, in the map) and distance_m.

#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

class ObjectDetection : public skill::Skill {
 public:
  explicit ObjectDetection(Robot& robot) : robot_(robot) {}

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;

 private:
  skill::Next Check(skill::Tick& tick);

  Robot& robot_;
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
};

}  // namespace musher::skills
