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

}  // namespace musher::meilin
