#include "musher/modules/meilin/nodes/place.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "musher/modules/meilin/nodes/edge.hpp"

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

std::optional<Wheels> FreshWheels(const Robot& robot, Time now) {
  const std::optional<Wheels> wheels = robot.wheels();
  if (!wheels || now - wheels->at > std::chrono::seconds(1)) return std::nullopt;
  return wheels;
}

Start Locate(Robot& robot, const MissionBoard& board, const Settings& settings, Time now,
             const std::string& node) {
  Start start{Remembered(board), ""};
  const std::optional<PoseFix> pose = FreshPose(robot, settings, now);
  if (!pose) {
    robot.Warn("no fresh /transformed/pose: " + node + " starts from the remembered cell " +
               CellText(start.place.cell));
    if (board.climbing.Get()) start.why = "a climb was not ended, and there is no fresh pose";
    return start;
  }
  const std::optional<RobotPlace> place = PlaceOf(*pose, settings);
  if (!place) {
    start.why =
        fmt::format("Current /transformed/pose is outside Meilin grid: x {:.2f} m, y {:.2f} m",
                    pose->x_m, pose->y_m);
    return start;
  }
  start.place = *place;
  const OffEdge way = PlanOffEdge(settings, *pose, FreshWheels(robot, now));
  if (way.on_edge) {
    start.why = node + " does not begin " + (way.unclear.empty() ? way.text : way.unclear);
  }
  return start;
}

std::string CheckedElsewhere(const MissionBoard& board, Cell cell, const std::string& node) {
  if (!board.segment_open.Get()) return "";
  const Segment segment = board.current_segment.Get();
  const Cell checked{segment.from_row, segment.from_col};
  if (!IsInside(checked) || checked == cell) return "";
  return node + " was checked from " + CellText(checked) + ", and the robot is on " +
         CellText(cell);
}

std::string WrongBody(const Robot& robot, const Settings& settings, Time now, double height_mm) {
  const std::optional<Wheels> wheels = FreshWheels(robot, now);
  const double most_mm = std::max(kOutWheelMm, settings.normal_height_mm + kLongWheelMm);
  if (wheels && LongestMm(*wheels) > most_mm)
    return "its wheels are still out: " + WheelsText(*wheels);
  const std::optional<PoseFix> pose = FreshPose(robot, settings, now);
  if (!pose || std::isnan(pose->z_m)) return "";
  const double over_mm = pose->z_m * 1000 - height_mm;
  if (over_mm <= most_mm + kLongWheelMm && over_mm >= -kOutWheelMm) return "";
  return fmt::format("its body is at {:.0f} mm, on a platform of {:g} mm", pose->z_m * 1000,
                     height_mm);
}

}  // namespace musher::meilin
