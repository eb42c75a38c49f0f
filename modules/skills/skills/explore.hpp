#pragma once
// Drives or flies over an area in lanes, so that it has been everywhere (coverage/coverage.hpp).
//
//   boundary                m, the corners in the map: [[0, 0], [20, 0], [20, 20], [0, 20]]
//   holes                   several such lists: [[[5, 5], [7, 5], [7, 7]]]; default none
//   lane_width              m, from lane to lane, default 2.0
//   robot_radius            m, room to boundary and holes, default 0.5
//   interpolation_distance  m, from point to point of the path, default 0.05; at least 0.01
//   interpolation_method    linear
//
// A flyer stays at its height, and has to be in the air. Heights of corners do not count.
//
//   INITIALIZING         the path is computed, planner and controller are reachable within 2.0 s
//   NAVIGATING_TO_START  60 s, on a way of the planner
//   EXECUTING            120 s, along the path; where an obstacle stays on it, on a way of the
//                        planner to the next free point of the path
//   STOPPING             of a cancellation: until the robot stands
//
// It fails when less than half of the path was free. A planner or controller that is lost: as in
// goal_skill.hpp; it continues where it was, as after a pause. Details: those of navigate_to,
// path_length, skipped (both m) and lanes.

#include <string>

#include "musher/modules/skills/coverage/coverage.hpp"
#include "musher/modules/skills/skills/travel_skill.hpp"

namespace musher::skills {

class Explore : public TravelSkill {
 public:
  using TravelSkill::TravelSkill;

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;

 private:
  skill::Next Initialize(skill::Tick& tick);
  skill::Next GoToStart(skill::Tick& tick);
  skill::Next Execute(skill::Tick& tick);
  Result<> MakePath(skill::Tick& tick);
  // The way of the planner to the point of the path `target_`, or, where there is none, to a later
  // one. kDone: there.
  TravelStep Approach(skill::Tick& tick);
  skill::Next After(const TravelStep& step);
  // Along the path from where the robot is.
  void BeginRest(const skill::Tick& tick);
  void NoteProgress(skill::Tick& tick);
  // The first point that is so far behind `index`; the last one of the path at most.
  std::size_t Ahead(std::size_t index, double distance_m) const;
  void SkipTo(skill::Tick& tick, std::size_t index);
  skill::Next Finish(const skill::Tick& tick) const;

  coverage::Plan plan_;
  navigation::Path path_;              // empty: not computed yet
  std::optional<std::size_t> target_;  // of Approach()
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId to_start_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
};

}  // namespace musher::skills
