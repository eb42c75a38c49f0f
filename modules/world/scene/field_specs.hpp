#pragma once
// A competition field: a grid of platforms of different heights, boxes on them, the robot R2 on
// four wheels of variable height, and what its partner R1 does. FIELD.md explains the geometry.
//
// Positions are metres in the place's frame ("map"): x towards larger rows, y towards larger
// columns. Heights of platforms and wheels are millimetres, as in the robot's topics. Plain values.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::world {

struct FieldCell {
  int row = 0;
  int col = 0;

  friend bool operator==(const FieldCell&, const FieldCell&) = default;
};

// A box on a platform. A fake one can be taken as the others, and is counted as they are.
enum class KfsKind : std::uint8_t { kKfs1, kKfs2, kFake };
const char* NameOf(KfsKind kind);  // "KFS1", "KFS2", "fake"

struct KfsSpec {
  std::string name;
  KfsKind kind = KfsKind::kKfs1;
  FieldCell cell;
};

inline constexpr double kKfsSizeM = 0.35;  // of its edges

// The robot. Its commands and limits; its geometry is in body/lift_body.hpp.
struct LiftSpec {
  Eigen::Vector2d start_m{0, 0};
  double start_yaw_rad = 0;
  double speed_m_s = 1.5;
  double acceleration_m_s2 = 2.5;
  double turn_rad_s = 1.5;
  double turn_acceleration_rad_s2 = 6;
  Duration command_timeout = Milliseconds(200);  // without a velocity it stops
  double wheel_mm_s = 400;                       // speed of a wheel, up and down
  double most_mm = 420;                          // height of a wheel
  double rest_mm = 20;
  double reach_m = 1.1;            // of the arm, from the robot's centre to that of a box
  double grasp_tolerance_mm = 60;  // by which a box may be higher or lower than the arm
  int stores = 3;                  // boxes in the body, besides the one in the gripper
  // How long a command of the arm or the spear takes, by its number; the first one is for idle.
  std::array<double, 7> arm_s{0.2, 3, 2, 1.5, 2, 3, 3};
  std::array<double, 5> spear_s{0.2, 2, 3, 2, 2};
};

struct PartnerSpec {
  double ready_after_s = 3;  // after the spear is docked
};

struct FieldSpec {
  std::string side = "blue";
  int rows = 6;
  int cols = 3;
  double cell_m = 1.2;
  Eigen::Vector2d origin_m{1.2, 1.2};  // the centre of cell (0, 0)
  std::vector<double> heights_mm;      // of this side, row by row
  std::vector<KfsSpec> boxes;
  LiftSpec robot;
  PartnerSpec partner;

  Eigen::Vector2d CentreOf(const FieldCell& cell) const;
  // The cell that contains the point, also one outside of the grid.
  FieldCell CellOf(const Eigen::Vector2d& point_m) const;
  bool Has(const FieldCell& cell) const;
  // 0 outside of the grid.
  double HeightMm(const FieldCell& cell) const;
  double HeightMm(const Eigen::Vector2d& point_m) const { return HeightMm(CellOf(point_m)); }
};

}  // namespace musher::world
