#pragma once
// What the skills have in common that move the robot from place to place: a state STOPPING, at the
// end of the task and of a cancellation, until the robot stands; in a pause and at every end its
// drive is cancelled and the robot stands. A flyer that was put down or taken in a pause does not
// go on after it.
//
// What it needs and lacks, a map, a planner, a controller, odometry or a scan, is waited for at a
// stand in INITIALIZING, with an attempt every 2 s, up to the parameter `lost_limit`; then it fails
// with the reason. Its messages say what it waits for.
//
// Units, frames and threads: those of robot.hpp.

#include <chrono>
#include <optional>
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
  // A flyer has to be in the air, and not in a hand.
  Result<> MayResume() override;

 protected:
  // In each step before it moves: fails where it may not go on after a pause, see MayResume().
  Result<> CheckAfterPause();
  // The task is done: to STOPPING, which then succeeds.
  skill::Next Complete(skill::Tick& tick);
  // A step of STOPPING. `success`: the message, if the task was done.
  skill::Next Stop(skill::Tick& tick, const std::string& success = {});

  // Adds `lost_limit`.
  static void DeclareLostLimit(skill::Table& table);
  static Result<> CheckLostLimit(const skill::Values& parameters);
  // A step of INITIALIZING. Nullopt: all is reachable. `doing`: the message before anything was
  // missing for a second.
  std::optional<skill::Next> WaitForParts(skill::Tick& tick, double progress,
                                          const std::string& prefix, const std::string& doing);
  // An attempt has failed because something is lost: to INITIALIZING, or, after `lost_limit`, the
  // failure.
  skill::Next AfterLoss(skill::Tick& tick, const std::string& prefix, const std::string& why);
  // In each step in which it drives: nothing is missing any more.
  void NoteDriving(skill::Tick& tick) const;
  // Why it waits in INITIALIZING.
  std::string WhyLost(const skill::Tick& tick) const;

  // In each step of a skill that drives and does not give way: others give way to it.
  void DoNotGiveWay() { robot_.NoteCornered(std::chrono::seconds(1)); }

  Robot& robot_;
  Travel travel_;
  skill::StateId initializing_ = skill::kIdle;  // for Declare() to set
  skill::StateId stopping_ = skill::kIdle;      // for Declare() to set

 private:
  bool was_paused_ = false;  // and no step with a pose since then
};

}  // namespace musher::skills
