#pragma once
// Goes towards a place, or in a direction, and keeps clear of what the scan sees, without a map and
// a planner (vector_field.hpp). For robots on the ground.
//
//   goal_pos        m, x y in the map; empty: goes by `heading` (default)
//   heading         rad to the left of where the robot looks at the begin, default 0
//   distance        m in that direction, default 3.0; not used with goal_pos
//   speed           m/s, default 0.3; above 0, at most 1.0
//   blocked_limit   s without a free direction, after which it fails; default 10
//
//   INITIALIZING   scan and odometry are there within 2.0 s
//   EXECUTING      120 s; at the goal within 0.2 m; where it is blocked, it stands
//   STOPPING       at the end: until the robot stands
//
// It is never faster than it can brake before what is ahead. A path out of a dead end is not its
// task: it fails 30 s after it has come nearer to its goal. Without scan or odometry it stands, and
// fails after 3 s. Details: distance_to_goal (m), current_velocity (m/s), free_ahead (m).

#include <optional>
#include <string>

#include "musher/modules/skills/skills/travel_skill.hpp"

namespace musher::skills {

class AvoidObstacle : public TravelSkill {
 public:
  using TravelSkill::TravelSkill;

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;

 private:
  struct Aim {
    double left_m = 0;      // to the goal
    double wanted_rad = 0;  // in the frame of the body
  };

  std::optional<std::string> WhyRefused(const skill::Values& parameters) const;
  std::optional<std::string> Missing() const;
  skill::Next Initialize(skill::Tick& tick);
  skill::Next Execute(skill::Tick& tick);
  // Once in each step of EXECUTING. By `heading` the odometry counts, which no correction of the
  // localisation moves.
  Aim AimOf(skill::Tick& tick, const navigation::Pose& pose);

  double direction_rad_ = 0;
  Duration blind_{};
  Duration blocked_{};
  Duration without_progress_{};
  std::optional<double> nearest_m_;        // to the goal, so far
  std::optional<navigation::Point> last_;  // by the odometry
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
};

}  // namespace musher::skills
