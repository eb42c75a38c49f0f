#pragma once
// Drives or flies over an area in lanes, so that it has been everywhere (coverage/coverage.hpp).
//
//   boundary                m, the corners in the map: [[0, 0], [20, 0], [20, 20], [0, 20]]; or
//                           several such lists, one area after the other, as `uncovered` has them
//   holes                   several such lists: [[[5, 5], [7, 5], [7, 7]]]; default none
//   lane_width              m, from lane to lane, default 2.0
//   robot_radius            m, room to boundary and holes, default 0.5
//   interpolation_distance  m, from point to point of the path, default 0.05; at least 0.01
//   interpolation_method    linear
//   least_covered           of the lanes, 0 to 1, so that it is completed; default 0.9
//   lost_limit              s at a stand without map, planner, controller, odometry or scan, then
//                           it fails; default 20
//
// A flyer stays at its height, and has to be in the air. Heights of corners do not count. On the
// ground what the map has as blocked is left out of the path from the begin, and counts as no part
// of the area; cells that it does not know belong to it. Areas are planned in several steps, some
// corners in each.
//
//   INITIALIZING         the path is computed, planner and controller are reachable
//   NAVIGATING_TO_START  60 s, on a path of the planner
//   EXECUTING            120 s, along the path; where an obstacle stays on it, on a path of the
//                        planner to the next free point of the path, metre by metre
//   STOPPING             of a cancellation: until the robot stands
//
// It fails once more than half of the path was blocked, and as partial at its end when less than
// `least_covered` of the lanes is covered: of what was blocked and of what no path leads to nothing
// is known. What is late or lost is waited for (travel_skill.hpp); it continues where it was, as
// after a pause. Details: those of navigate_to, path_length, left_out_by_map, which is no part of
// it, skipped (all m) and lanes; at every end covered (%) and, unless that is all, uncovered: what
// is left, in strips of a lane, as a boundary for the next run.

#include <memory>
#include <optional>
#include <string>
#include <vector>

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
  skill::Next Go(skill::Tick& tick);
  skill::Next Initialize(skill::Tick& tick);
  skill::Next GoToStart(skill::Tick& tick);
  skill::Next Execute(skill::Tick& tick);
  // A part of the work for the path; nullopt: it is made.
  std::optional<skill::Next> MakePath(skill::Tick& tick);
  Result<> BeginPath(const skill::Tick& tick);
  // The path of the nearest of the areas that are left, after those of before; its corners.
  Result<std::size_t> AddNearest(const skill::Tick& tick);
  Result<> AddPath(const coverage::Region& region, const coverage::GroundPoint& start,
                   const skill::Tick& tick);
  Result<> EndPath(skill::Tick& tick);
  // The path of the planner to the next point of the path, or, where that is blocked, to a later
  // one. kDone: there, or there is no later one.
  TravelStep Approach(skill::Tick& tick);
  bool IsFarFrom(const navigation::Pose& target) const;
  skill::Next After(skill::Tick& tick, const TravelStep& step);
  // Along the path from where the robot is.
  void BeginRest(const skill::Tick& tick);
  void NoteProgress(skill::Tick& tick);
  // Whether the body fits there, by the map.
  bool Fits(const navigation::CellMap& map, const navigation::Point& at) const;
  // Notes of a path where the map leaves it no room.
  void NoteCuts(const navigation::CellMap& map, const navigation::Path& path,
                const std::vector<bool>& on_lane);
  // Adds to the path what of this one is not cut out.
  void AddUncut(const navigation::Path& path, const std::vector<bool>& on_lane);
  // Takes what is cut out of the sums.
  void CountCuts(const navigation::Path& path, const std::vector<bool>& on_lane,
                 const std::vector<bool>& is_cut);
  void CloseArea();
  // The last point of its area.
  std::size_t EndOf(std::size_t index) const;
  // To the next area; false: there is none.
  bool BeginNextArea(skill::Tick& tick);
  // The first point that is so far behind `index`; the last one of its area at most.
  std::size_t Ahead(std::size_t index, double distance_m) const;
  // Leaves out the next part of the path.
  void Skip(skill::Tick& tick, const std::string& why);
  bool IsMostlyBlocked(const skill::Tick& tick) const;
  skill::Next FailBlocked(const skill::Tick& tick) const;
  // The lanes that it has left out, with those of the rest of the path if it has not reached its
  // end.
  std::vector<coverage::Edge> Uncovered(const skill::Tick& tick, bool at_end) const;
  double ShareCovered(const std::vector<coverage::Edge>& uncovered) const;
  // Adds what is covered and what is not, if this is the end.
  skill::Next AtEnd(skill::Tick& tick, skill::Next next) const;
  skill::Next Finish(skill::Tick& tick) const;

  bool made_ = false;                   // the path
  std::vector<coverage::Region> left_;  // areas of which it has no path yet
  skill::Numbers begin_;                // where the robot was
  skill::Numbers cuts_;                 // see kCuts
  double cut_m_ = 0;                    // that they take out of the path
  coverage::Plan plan_;                 // sums of all areas, without the cuts; no corners
  navigation::Path path_;
  std::vector<bool> on_lane_;               // of the line from each point to the next one
  std::vector<std::size_t> last_of_areas_;  // points of the path, in ascending order
  std::size_t uncut_ = 0;                   // points of the paths so far, with what is cut out
  std::shared_ptr<const navigation::CellMap> map_;  // only while the path is made
  bool lacks_map_ = false;                          // it was to have one
  bool approaches_ = false;                         // it is on a path of the planner
  std::string obstacle_;                            // why it has left out a part
  skill::StateId to_start_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
};

}  // namespace musher::skills
