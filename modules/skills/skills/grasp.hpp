#pragma once
// The skill grasp: the robot comes close to an object, and its hand takes it.
//
//   INITIALIZING  checks hand and parameters; waits 0.5 s before another attempt
//   PREPARING     is the object near enough? If it is too far by at most `approach`, the robot
//                 drives towards it, slowly and with a scan only     20 s
//   EXECUTING     takes it, and looks whether it is held             6 s
//   FINALIZING    at a cancellation, waits for the hand              3 s
//
// A lost reply, an object that has moved and one that slipped are retried three times. The
// detail `holds` has the object that the robot holds at the end, also after a cancellation.

#include <memory>

#include "musher/behavior/skill/pattern.hpp"
#include "musher/modules/skills/skills/grip.hpp"

namespace musher::skills {

class Grasp : public skill::PatternSkill {
 public:
  Grasp(Robot& robot, std::shared_ptr<Grip> grip) : robot_(robot), grip_(std::move(grip)) {}

  skill::Next OnLimit(skill::Tick& tick) override;
  void OnEnd(const skill::Ended& ended) override;
  void OnPause() override { robot_.StopMotion(); }

 private:
  void Describe(skill::Table& table) override;
  Outcome Initialize(skill::Tick& tick) override;
  Outcome Prepare(skill::Tick& tick) override;
  Outcome Execute(skill::Tick& tick) override;
  Outcome Finalize(skill::Tick& tick) override;
  Outcome ComeCloser(const HandRequest& request, skill::Tick& tick);
  Outcome Verify(const std::string& object, skill::Tick& tick);

  Robot& robot_;
  const std::shared_ptr<Grip> grip_;
  HandCall call_;
};

}  // namespace musher::skills
