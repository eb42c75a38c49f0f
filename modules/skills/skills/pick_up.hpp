#pragma once
// The skill pick_up: the hand takes an object that is within reach. The robot does not move; grasp
// also comes closer.
//
//   INITIALIZING  checks hand and parameters; waits 0.5 s before another attempt
//   CHECKING      is the object near enough?    3 s; too far: fails
//   ATTACHING     takes it                      3 s; too far now (it has moved): checked again
//
// A lost reply, and an object that has moved, are retried three times. A cancellation while the
// hand takes the object waits for the hand, and says whether the robot holds it.

#include <memory>

#include "musher/modules/skills/skills/grip.hpp"

namespace musher::skills {

class PickUp : public skill::Skill {
 public:
  PickUp(Robot& robot, std::shared_ptr<Grip> grip) : robot_(robot), grip_(std::move(grip)) {}

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next Cancel(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;
  void OnEnd(const skill::Ended& ended) override;

 private:
  skill::Next Initialize(skill::Tick& tick);
  skill::Next CheckDistance(skill::Tick& tick);
  skill::Next Attach(skill::Tick& tick);

  Robot& robot_;
  const std::shared_ptr<Grip> grip_;
  HandCall call_;
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId checking_ = skill::kIdle;
  skill::StateId attaching_ = skill::kIdle;
};

}  // namespace musher::skills
