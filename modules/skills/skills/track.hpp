#pragma once
// Follows a target that reports its pose, and keeps a distance from it.
//
//   target_topic   nav_msgs/Odometry of the target, default /target_0/odom
//   track_period   poses of the target, as they come, from plan to plan; default 10
//   distance       m, kept from the target, default 1.5
//   lost_limit     s without a pose, or at one place without a path, then it fails; default 10
//   duration       s, then it succeeds; 0: until it is cancelled (default)
//
// A flyer stays at its height. While the robot is at most 0.3 m farther away than `distance`, it
// stands; while it is nearer than half of it, it backs away.
//
//   INITIALIZING   until the servers are reachable and the target reports its pose, `lost_limit`
//   EXECUTING      plans while it drives: a new path replaces the old one without a stop
//   STOPPING       at the end: until the robot stands
//
// A target that is lost: it says so after 1 s, and goes to where the target was. A lost server, a
// goal without a path and an obstacle end it only once the robot makes no progress for
// `lost_limit`. Details: those of navigate_to and target_distance (m).

#include <optional>
#include <string>

#include "musher/modules/skills/skills/travel_skill.hpp"

namespace musher::skills {

class Track : public TravelSkill {
 public:
  using TravelSkill::TravelSkill;

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;

 private:
  std::string WhyNotReady(const skill::Tick& tick) const;
  std::optional<std::string> WhyRefused(const skill::Values& parameters) const;
  skill::Next Initialize(skill::Tick& tick);
  skill::Next Execute(skill::Tick& tick);
  // Where the robot has to be for this target; nullopt: it may stay.
  std::optional<navigation::Pose> GoalFor(const navigation::Pose& target, double distance_m) const;
  double DistanceTo(const navigation::Pose& target) const;
  void PlanAndDrive(const skill::Tick& tick);
  void Plan(Duration step);
  // A drive is done, or none is needed.
  void HasPath();
  // Keeps the reason of a failure.
  void Note(const TravelStep& step);
  void Report(skill::Tick& tick) const;

  std::optional<navigation::Pose> target_;  // as it was seen last
  std::optional<navigation::Pose> goal_;    // that is planned, or that the drive has
  std::int64_t poses_ = 0;                  // since the last plan
  std::uint64_t counted_ = 0;               // of the robot's count of them
  Duration unseen_{};
  Standstill standstill_;  // since it has to move
  std::string trouble_;    // why there is no path
  skill::StateId executing_ = skill::kIdle;
};

}  // namespace musher::skills
