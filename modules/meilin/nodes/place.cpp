#include "musher/modules/meilin/nodes/place.hpp"

namespace musher::meilin {

std::optional<PoseFix> FreshPose(const Robot& robot, const Settings& settings, Time now) {
  const std::optional<PoseFix> pose = robot.pose();
  if (!pose || !pose->IsFresh(now, settings.pose_timeout_s)) return std::nullopt;
  return pose;
}

RobotPlace Remembered(const MissionBoard& board) {
  return {{board.row.Get(), board.col.Get()},
          board.height_mm.Get(),
          board.yaw_rad.Get(),
          board.is_cell_center.Get(),
          false};
}

std::optional<RobotPlace> PlaceOf(const PoseFix& pose, const Settings& settings) {
  const Point2 at{pose.x_m, pose.y_m};
  const std::optional<Cell> cell = settings.grid.CellAt(at);
  if (!cell) return std::nullopt;
  return RobotPlace{*cell, static_cast<double>(settings.grid.HeightMm(*cell)),
                    NormalizeYaw(pose.yaw_rad), settings.grid.IsAtCentre(at, *cell), true};
}

}  // namespace musher::meilin
