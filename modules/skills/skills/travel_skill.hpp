#pragma once
// What the skills have in common that move the robot from place to place: a state STOPPING, at the
// end of the task and of a cancellation, until the robot stands; in a pause and at every end its
// drive is cancelled and the robot stands.
//
// Units, frames and threads: those of robot.hpp.

#include <chrono>
#include <string>

#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/skills/travel.hpp"

namespace musher::skills {

class TravelSkill : public skill::Skill {
 public:
  explicit TravelSkill(Robot& robot) : robot_(robot), travel_(robot) {}

  skill::Next Cancel(skill::Tick& tick) final;
  void OnEnd(const skill::Ended& ended) final;
  void OnPause() override;

 protected:
  // The task is done: to STOPPING, which then succeeds.
  skill::Next Complete(skill::Tick& tick);
  // A step of STOPPING. `success`: the message, if the task was done.
  skill::Next Stop(skill::Tick& tick, const std::string& success = {});

  // In each step of a skill that drives and does not give way: others give way to it.
  void DoNotGiveWay() { robot_.NoteCornered(std::chrono::seconds(1)); }

  Robot& robot_;
  Travel travel_;
  skill::StateId stopping_ = skill::kIdle;  // for Declare() to set
};

}  // namespace musher::skills
