#pragma once
// One segment of a plan: what a mission does next. Pure values. Lengths are metres in the frame
// map, heights millimetres, angles radians, speeds m/s, times seconds, as on the wire.

#include <string>
#include <string_view>

namespace musher::meilin {

// Types of the segments of an action sequence. Those of old plans: segments_json.hpp.
inline constexpr std::string_view kMoveType = "move";
inline constexpr std::string_view kFetchType = "fetch";
inline constexpr std::string_view kPlanDoneType = "PLAN_DONE";  // follows the last step

struct Segment {
  int index = 0;             // from 0
  std::string segment_type;  // kMoveType, …
  std::string debug_name;    // "move (1, 0)"

  // Of an action sequence. The cell from which it was checked; -1: not known.
  int from_row = -1;
  int from_col = -1;
  int move_row = 0;
  int move_col = 0;
  double target_height_mm = 0;  // of the platform
  int kfs_row = 0;
  int kfs_col = 0;
  double height_diff = 0;  // mm: platform of the box minus platform of the robot
  double target_yaw = 0;

  // Of an old plan.
  double target_x = 0;
  double target_y = 0;
  double max_speed = 0.5;
  double timeout_sec = 30;
  double suspension_timeout_sec = 10;
  int climb_mode = 0;       // a mode of the action suspension_control
  int climb_direction = 0;  // a direction of it
  double climb_height = 0;  // mm
  int arm_command = 0;      // a command of the action arm_action
  bool wait_result = true;  // of the arm
  int spear_command = 0;    // a command of the action spear_action

  friend bool operator==(const Segment&, const Segment&) = default;
};

}  // namespace musher::meilin
