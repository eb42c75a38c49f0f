#pragma once
// One recovery as a skill of its own: leave_tight_start, clear, back_up or spin. What they do and
// when they fail: recovery.hpp. They have no parameters; a flyer has only `clear`.
//
// Details: moved_m, turned_rad. In a pause and at every end the robot stands.

#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/skills/recovery.hpp"

namespace musher::skills {

class RecoverySkill : public skill::Skill {
 public:
  RecoverySkill(Robot& robot, RecoveryKind kind) : robot_(robot), kind_(kind), recovery_(robot) {}

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  void OnEnd(const skill::Ended& ended) override;
  void OnPause() override;

 private:
  Robot& robot_;
  const RecoveryKind kind_;
  Recovery recovery_;
  bool begun_ = false;  // not after a restore
};

}  // namespace musher::skills
