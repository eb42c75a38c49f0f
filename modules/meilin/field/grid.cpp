#include "musher/modules/meilin/field/grid.hpp"

#include <cmath>
#include <cstdlib>

namespace musher::meilin {
namespace {

using Heights = std::array<std::array<int, kCols>, kRows>;  // mm

constexpr Heights kBlueHeights = {{
    {0, 0, 0},
    {400, 200, 400},
    {600, 400, 200},
    {400, 600, 400},
    {200, 400, 200},
    {0, 0, 0},
}};

}  // namespace

Side SideOf(std::string_view text) {
  return text == "red" ? Side::kRed : Side::kBlue;
}

std::string_view SideText(Side side) {
  return side == Side::kRed ? "red" : "blue";
}

int CodeOf(Direction direction) {
  return static_cast<int>(direction);
}

double YawOf(Direction direction) {
  switch (direction) {
    case Direction::kForward:
      return 0;
    case Direction::kLeft:
      return kPi / 2;
    case Direction::kRight:
      return -kPi / 2;
    case Direction::kBackward:
      return kPi;
  }
  return 0;
}

std::string_view DirectionText(Direction direction) {
  switch (direction) {
    case Direction::kForward:
      return "forward";
    case Direction::kLeft:
      return "left";
    case Direction::kRight:
      return "right";
    case Direction::kBackward:
      return "backward";
  }
  return "forward";
}

Direction Opposite(Direction direction) {
  switch (direction) {
    case Direction::kForward:
      return Direction::kBackward;
    case Direction::kLeft:
      return Direction::kRight;
    case Direction::kRight:
      return Direction::kLeft;
    case Direction::kBackward:
      return Direction::kForward;
  }
  return Direction::kForward;
}

bool IsInside(Cell cell) {
  return cell.row >= 0 && cell.row < kRows && cell.col >= 0 && cell.col < kCols;
}

bool AreNeighbours(Cell a, Cell b) {
  return DirectionTo(a, b).has_value();
}

std::optional<Direction> DirectionTo(Cell from, Cell to) {
  for (const Direction direction : kDirections) {
    if (Next(from, direction) == to) return direction;
  }
  return std::nullopt;
}

Cell Next(Cell from, Direction direction) {
  switch (direction) {
    case Direction::kForward:
      return {from.row + 1, from.col};
    case Direction::kLeft:
      return {from.row, from.col + 1};
    case Direction::kRight:
      return {from.row, from.col - 1};
    case Direction::kBackward:
      return {from.row - 1, from.col};
  }
  return from;
}

std::string CellText(Cell cell) {
  return "(" + std::to_string(cell.row) + ", " + std::to_string(cell.col) + ")";
}

double NormalizeYaw(double yaw_rad) {
  return std::remainder(yaw_rad, 2 * kPi);
}

double YawDistance(double a_rad, double b_rad) {
  return std::abs(NormalizeYaw(a_rad - b_rad));
}

Direction NearestDirection(double yaw_rad) {
  Direction nearest = Direction::kForward;
  for (const Direction direction : kDirections) {
    if (YawDistance(yaw_rad, YawOf(direction)) < YawDistance(yaw_rad, YawOf(nearest))) {
      nearest = direction;
    }
  }
  return nearest;
}

double SnapYaw(double yaw_rad) {
  return YawOf(NearestDirection(yaw_rad));
}

int Grid::HeightMm(Cell cell) const {
  if (!IsInside(cell)) return 0;
  const int col = side == Side::kRed ? kCols - 1 - cell.col : cell.col;
  return kBlueHeights.at(static_cast<std::size_t>(cell.row)).at(static_cast<std::size_t>(col));
}

Point2 Grid::Centre(Cell cell) const {
  return {origin.x_m + cell.row * size_m, origin.y_m + cell.col * size_m};
}

Pose2 Grid::CentrePose(Cell cell, double yaw_rad) const {
  const Point2 centre = Centre(cell);
  return {centre.x_m, centre.y_m, yaw_rad};
}

std::optional<Cell> Grid::CellAt(Point2 at) const {
  if (!(size_m > 0)) return std::nullopt;
  const double row = std::round((at.x_m - origin.x_m) / size_m);
  const double col = std::round((at.y_m - origin.y_m) / size_m);
  if (!(row >= 0 && row < kRows && col >= 0 && col < kCols)) return std::nullopt;
  return Cell{static_cast<int>(row), static_cast<int>(col)};
}

double Grid::DistanceToCentre(Point2 at, Cell cell) const {
  const Point2 centre = Centre(cell);
  return std::hypot(at.x_m - centre.x_m, at.y_m - centre.y_m);
}

bool Grid::IsAtCentre(Point2 at, Cell cell) const {
  return DistanceToCentre(at, cell) <= centre_tolerance_m;
}

Pose2 Grid::GraspPose(Cell from, Cell box, double yaw_rad) const {
  const Point2 here = Centre(from);
  const Point2 there = Centre(box);
  const double length_m = std::hypot(there.x_m - here.x_m, there.y_m - here.y_m);
  if (!(length_m > 0)) return CentrePose(from, yaw_rad);
  const double before = (size_m / 2 + grasp_distance_m) / length_m;  // as a share of the line
  return {there.x_m - before * (there.x_m - here.x_m), there.y_m - before * (there.y_m - here.y_m),
          yaw_rad};
}

}  // namespace musher::meilin
