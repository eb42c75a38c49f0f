#pragma once
// Plans as they arrive on mf_action_seq: eight numbers a step, from a planner or a web page. A plan
// is checked as a whole, step by step from where the robot starts, before a part of it runs.
//
//   0       1    2    3                                        4         5 to 7
//   0 move  row  col  height of the cell, mm (0: not compared)  yaw, rad  not used
//   1 fetch row  col  height of the box minus present one, mm   yaw, rad  not used
//
// Pure functions; they never throw. Errors are sentences: they begin with a fixed text, then say
// the value, what was expected, and the step, counted from 1.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/modules/meilin/field/box_map.hpp"
#include "musher/modules/meilin/field/grid.hpp"
#include "musher/modules/meilin/plan/segment.hpp"

namespace musher::meilin {

inline constexpr std::size_t kNumbersPerStep = 8;
inline constexpr std::size_t kMostSteps = 1000;     // a field has 18 cells
inline constexpr std::size_t kMostPlanFaults = 50;  // reported of one plan

struct PlanRules {
  Grid grid;
  double yaw_tolerance_rad = 0.12;
  double height_tolerance_mm = 1.0;
  // Of the wheels while the robot drives. A fetch sets them to this plus its height difference,
  // which must not be negative and not above the highest.
  double normal_height_mm = 20;
  double highest_wheel_mm = 430;
  // What is known of the boxes: a fetch takes one of them, a move comes over none that is still
  // there. Nothing: only the boxes of the plan are known.
  std::optional<BoxMap> boxes;
  std::vector<Cell> taken;  // boxes that are not there any more
  bool kfs1_blocks = true;  // a box of the partner is in the way, too
};

// Where the robot is before the first step.
struct PlanStart {
  Cell cell;
  double height_mm = 0;
  double yaw_rad = 0;
  bool at_centre = true;

  friend bool operator==(const PlanStart&, const PlanStart&) = default;
};

// `live`: the pose of the robot if it is known and fresh. Inside the grid it decides; otherwise the
// robot has still to reach the field, and the plan starts at `initial`.
PlanStart StartOf(const Grid& grid, const PlanStart& initial, const std::optional<Pose2>& live);

struct PlanStep {
  bool fetch = false;
  Cell cell;             // to which the robot moves, or of the box
  double height_mm = 0;  // index 3
  double yaw_rad = 0;

  friend bool operator==(const PlanStep&, const PlanStep&) = default;
};

struct PlanFault {
  int step = 0;  // from 1; 0: the plan as a whole
  std::string message;
};

struct PlanReading {
  std::vector<Segment> segments;  // and one of kPlanDoneType; empty if there are faults
  std::vector<PlanFault> faults;  // in the order of the steps

  bool ok() const { return faults.empty(); }
  // The first fault; empty if there is none.
  std::string message() const { return faults.empty() ? "" : faults.front().message; }
};

// A layout may be empty or anything that does not contradict the data.
PlanReading ReadActionSequence(const msg::Float32MultiArray& plan, const PlanRules& rules,
                               const PlanStart& start);

// The same plan as a message, with the layout of the competition's planner.
msg::Float32MultiArray ToActionSequence(const std::vector<PlanStep>& steps);

// The steps of a plan that ReadActionSequence() accepts.
std::vector<PlanStep> StepsOf(const msg::Float32MultiArray& plan);

std::string PlanIdOf(std::uint64_t number);  // "mf_action_seq_3"

}  // namespace musher::meilin
