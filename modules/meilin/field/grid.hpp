#pragma once
// The field of the match: 6 rows and 3 columns of platforms of different heights, pure values.
//
// Frame map: x towards larger rows, y towards larger columns, yaw 0 along x, positive
// counter-clockwise. So column + 1 is to the left of a robot that looks along x. Lengths of the
// field are metres, heights of platforms millimetres, angles radians in [-pi, pi].
// Row 0 is the entry, row 5 the exit; both are on the ground. The numbers are those of the
// competition. Functions are pure, never throw, and take any number, NaN included.

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace musher::meilin {

inline constexpr int kRows = 6;
inline constexpr int kCols = 3;
inline constexpr double kPi = std::numbers::pi;

// The half of the field that the team has. They are mirrored.
enum class Side { kBlue, kRed };

// "red" is kRed, every other text is kBlue.
Side SideOf(std::string_view text);
std::string_view SideText(Side side);  // "blue", "red"

struct Cell {
  int row = 0;
  int col = 0;

  friend bool operator==(const Cell&, const Cell&) = default;
};

// Half the side of the robot's square hull, and what it keeps from an edge beside its way.
inline constexpr double kHullHalfM = 0.3;
inline constexpr double kHullClearM = 0.33;

struct Point2 {
  double x_m = 0;
  double y_m = 0;
};

struct Pose2 {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};

// In the frame map, whatever the heading of the robot is. The values are the codes of the action
// suspension_control.
enum class Direction : int { kForward = 0, kLeft = 1, kRight = 2, kBackward = 3 };

inline constexpr std::array<Direction, 4> kDirections = {Direction::kForward, Direction::kLeft,
                                                         Direction::kRight, Direction::kBackward};

int CodeOf(Direction direction);                      // 0, 1, 2, 3
double YawOf(Direction direction);                    // 0, pi/2, -pi/2, pi
std::string_view DirectionText(Direction direction);  // "forward", "left", "right", "backward"
Direction Opposite(Direction direction);

bool IsInside(Cell cell);
bool AreNeighbours(Cell a, Cell b);  // they share an edge
// From a cell to a neighbour; nothing for cells that are none.
std::optional<Direction> DirectionTo(Cell from, Cell to);
Cell Next(Cell from, Direction direction);  // may be outside
std::string CellText(Cell cell);            // "(1, 2)": row, column

double NormalizeYaw(double yaw_rad);             // in [-pi, pi]
double YawDistance(double a_rad, double b_rad);  // in [0, pi]; NaN stays NaN
// The direction whose yaw is nearest; kForward for NaN.
Direction NearestDirection(double yaw_rad);
// That yaw: 0, pi/2, -pi/2 or pi.
double SnapYaw(double yaw_rad);

struct Grid {
  Side side = Side::kBlue;
  double size_m = 1.2;               // of a cell
  Point2 origin = {1.2, 1.2};        // the centre of cell (0, 0)
  double centre_tolerance_m = 0.15;  // a robot so near to a centre is at it
  double grasp_distance_m = 0.4;     // from the edge of the cell of a box

  int HeightMm(Cell cell) const;  // of the platform; 0 outside the grid
  Point2 Centre(Cell cell) const;
  Pose2 CentrePose(Cell cell, double yaw_rad) const;
  // The cell in which a position is; nothing outside the grid, for a number that is not finite, or
  // if the size is not positive.
  std::optional<Cell> CellAt(Point2 at) const;
  // The first cell of another height than `height_mm`, within `tolerance_mm`, that the hull of a
  // robot comes over on the straight line between two points; nothing if there is none. The ground
  // around the grid has the height 0.
  std::optional<Cell> OtherHeightOnLine(Point2 from, Point2 to, double height_mm,
                                        double tolerance_mm) const;
  // The cells that the hull comes over on that line, by row and column.
  std::vector<Cell> CellsOnLine(Point2 from, Point2 to) const;
  double DistanceToCentre(Point2 at, Cell cell) const;  // m
  bool IsAtCentre(Point2 at, Cell cell) const;

  // Where a robot of the cell `from` stands to take the box of the cell `box`: on the line of both
  // centres, half a cell and the grasp distance before the centre of the box. `from` itself if both
  // cells are the same.
  Pose2 GraspPose(Cell from, Cell box, double yaw_rad) const;
};

}  // namespace musher::meilin
