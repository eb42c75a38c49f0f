#include "musher/modules/meilin/field/grid.hpp"

#include <algorithm>
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

// Of a point from a square around `centre`.
double DistanceToSquare(Point2 at, Point2 centre, double half_m) {
  const double x_m = std::max(0.0, std::abs(at.x_m - centre.x_m) - half_m);
  const double y_m = std::max(0.0, std::abs(at.y_m - centre.y_m) - half_m);
  return std::hypot(x_m, y_m);
}

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

std::vector<Cell> Grid::CellsOnLine(Point2 from, Point2 to) const {
  std::vector<Cell> cells;
  constexpr double kStepM = 0.02;
  const double length_m = std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
  if (!std::isfinite(length_m) || length_m > 1000) return cells;
  const int steps = 1 + static_cast<int>(length_m / kStepM);
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) {
      const Point2 centre = Centre({row, col});
      for (int i = 0; i <= steps; ++i) {
        const double share = static_cast<double>(i) / steps;
        const Point2 at{from.x_m + share * (to.x_m - from.x_m),
                        from.y_m + share * (to.y_m - from.y_m)};
        if (DistanceToSquare(at, centre, size_m / 2) >= kHullClearM) continue;
        cells.push_back({row, col});
        break;
      }
    }
  }
  return cells;
}

std::optional<Cell> Grid::OtherHeightOnLine(Point2 from, Point2 to, double height_mm,
                                            double tolerance_mm) const {
  for (const Cell cell : CellsOnLine(from, to)) {
    if (std::abs(HeightMm(cell) - height_mm) > tolerance_mm) return cell;
  }
  return std::nullopt;
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
