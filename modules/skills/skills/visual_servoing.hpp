#pragma once
// Comes to stand at a distance and bearing of a target that the robot's detectors see, without a
// map and a planner (visual_servo.hpp). For robots on the ground.
//
//   target              a name or category that its detectors report
//   distance            m, level, from the middle of the robot to that of the target; default 1.0
//   bearing             rad to the left at which the target stands then, default 0, at most 1.0
//   tolerance           m, default 0.05
//   bearing_tolerance   rad, default 0.1
//   speed               m/s, default 0.2; above 0, at most 0.5
//   lost_limit          s at a stand without a sighting that counts, then it fails; default 2
//
//   INITIALIZING   detectors, scan and odometry are there within 2.0 s
//   EXECUTING      60 s; turns, drives, stands until the target has been right for 0.5 s
//   STOPPING       at the end: until the robot stands
//
// It moves only on a sighting of the last 0.3 s. Without one, with two things of that name, a
// target that jumps, or without odometry or scan it stands, and fails with that reason after
// `lost_limit`. It looks for the target nowhere else: it has to be in view. What is in the way
// stops it, by the gate, and fails it after 10 s; backwards it goes only where a scan covers what
// is behind it. Details: target_distance (m), target_bearing (rad).

#include <optional>
#include <string>

#include "musher/modules/skills/skills/servo_drive.hpp"
#include "musher/modules/skills/skills/travel_skill.hpp"

namespace musher::skills {

class VisualServoing : public TravelSkill {
 public:
  using TravelSkill::TravelSkill;

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;
  void OnPause() override;

 private:
  std::optional<std::string> WhyRefused(const skill::Values& parameters) const;
  // Nullopt: all that it needs is there.
  std::optional<std::string> Missing(const skill::Values& parameters);
  skill::Next Execute(skill::Tick& tick);

  std::optional<ServoDrive> drive_;  // nullopt: it begins with the next step
  skill::StateId executing_ = skill::kIdle;
};

}  // namespace musher::skills
