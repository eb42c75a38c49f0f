#pragma once
// The skill place: the robot comes close to a target, and its hand puts the held object there.
//
//   INITIALIZING  checks hand, object and target; waits 0.5 s before another attempt
//   PREPARING     carries it: is the target near enough? If it is too far by at most `approach`,
//                 the robot drives towards it, slowly and with a scan only     20 s
//   EXECUTING     puts it there, and looks where it stands                     6 s
//   FINALIZING    at a cancellation, waits for the hand                        3 s
//
// The target is a place in the map, in metres. A lost reply is retried three times; a hand that
// does not reach the target comes closer, within `approach`. An object that does not stand within
// 0.1 m of the target in the end fails it: the robot does not hold it any more.

#include <memory>

#include "musher/behavior/skill/pattern.hpp"
#include "musher/modules/skills/skills/grip.hpp"

namespace musher::skills {

class Place : public skill::PatternSkill {
 public:
  Place(Robot& robot, std::shared_ptr<Grip> grip) : robot_(robot), grip_(std::move(grip)) {}

  skill::Next OnLimit(skill::Tick& tick) override;
  void OnEnd(const skill::Ended& ended) override;
  void OnPause() override { robot_.StopMotion(); }

 private:
  void Describe(skill::Table& table) override;
  Outcome Initialize(skill::Tick& tick) override;
  Outcome Prepare(skill::Tick& tick) override;
  Outcome Execute(skill::Tick& tick) override;
  Outcome Finalize(skill::Tick& tick) override;
  Outcome Verify(skill::Tick& tick);
  HandRequest Request(const skill::Tick& tick) const;

  Robot& robot_;
  const std::shared_ptr<Grip> grip_;
  HandCall call_;
};

}  // namespace musher::skills
