#pragma once
// The skill put_down: the hand releases an object, which falls to what is below it.
//
//   INITIALIZING  checks hand and object; waits 0.5 s before another attempt
//   RELEASING     releases it    3 s; a lost reply is retried three times
//
// Without an object it is the one that the robot holds. A cancellation while the hand releases it
// waits for the hand.

#include <memory>

#include "musher/modules/skills/skills/grip.hpp"

namespace musher::skills {

class PutDown : public skill::Skill {
 public:
  PutDown(Robot& robot, std::shared_ptr<Grip> grip) : robot_(robot), grip_(std::move(grip)) {}

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next Cancel(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;
  void OnEnd(const skill::Ended& ended) override;

 private:
  skill::Next Initialize(skill::Tick& tick);
  skill::Next Release(skill::Tick& tick);

  Robot& robot_;
  const std::shared_ptr<Grip> grip_;
  HandCall call_;
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId releasing_ = skill::kIdle;
};

}  // namespace musher::skills
