#pragma once
// Where a node believes the robot to be when it starts: by the live pose where that is fresh, else
// by what the mission remembers. Frame map; metres, radians, millimetres.

#include <optional>
#include <string>

#include "musher/modules/meilin/nodes/mission_board.hpp"
#include "musher/modules/meilin/nodes/settings.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin {

struct RobotPlace {
  Cell cell;
  double height_mm = 0;
  double yaw_rad = 0;
  bool is_center = true;
  bool live = false;
};

// The fresh live pose of the robot.
std::optional<PoseFix> FreshPose(const Robot& robot, const Settings& settings, Time now);
RobotPlace Remembered(const MissionBoard& board);
// Nothing: the fresh pose is outside the grid.
std::optional<RobotPlace> PlaceOf(const PoseFix& pose, const Settings& settings);
// The wheels, where they report now.
std::optional<Wheels> FreshWheels(const Robot& robot, Time now);

// Where a node starts, and the plan that it belongs to was checked from: the live pose, else what
// the mission remembers, with a warning in the name of `node`. `why`: why it cannot start there: it
// is outside the grid, or on an edge; else empty.
struct Start {
  RobotPlace place;
  std::string why;
};
Start Locate(Robot& robot, const MissionBoard& board, const Settings& settings, Time now,
             const std::string& node);
// Why the present segment does not begin on this cell: its plan was checked from another one.
// Empty: it may, or the node belongs to no plan.
std::string CheckedElsewhere(const MissionBoard& board, Cell cell, const std::string& node);
// Whether the robot's body is not where it is after a step that was done: its wheels are out, or
// its underside is at another height. Empty: it is, or that is not known.
std::string WrongBody(const Robot& robot, const Settings& settings, Time now, double height_mm);

}  // namespace musher::meilin
