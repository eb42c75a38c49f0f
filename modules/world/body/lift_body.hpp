#pragma once
// A robot on four wheels of variable height, on platforms: a pure model of its motion. FIELD.md has
// the geometry and the sequence of a climb as its sensors see it.
//
// - A velocity [x, y, turn] is in the frame of the body, m/s and rad/s. It is limited, the body
//   approaches it within its accelerations, and it counts as zero when it is too old.
// - Each wheel approaches its commanded height, mm, with the speed of the wheels.
// - At each corner the body stands on its wheel, or rests with its underside on a platform, by what
//   is higher. Where a wheel hangs the base only creeps, and it is held while such a wheel extends.
// - A platform that is higher than the underside blocks the body, one that is higher than a wheel's
//   lower end blocks that wheel; it slides along. This is a bump when no commanded height would
//   lift the body over that platform, else the body waits there.
// - A body that tilts too far, or drops, has fallen: it no longer moves until it is put down.
//
// Threads: none; time, platforms and boxes are arguments.

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <string>

#include "musher/modules/world/scene/field_specs.hpp"

namespace musher::world {

inline constexpr std::size_t kLiftWheels = 4;   // front-left, front-right, rear-left, rear-right
inline constexpr std::size_t kLiftRangers = 8;  // down and ahead of the front, left, rear, right
inline constexpr double kLiftHalfM = 0.3;       // of its square hull
inline constexpr double kLiftWheelM = 0.25;     // of a wheel from the centre, ahead and aside

using WheelHeights = std::array<double, kLiftWheels>;  // mm

// The ground, and what else the hull cannot enter.
struct LiftPlace {
  const FieldSpec& field;
  // The name of a box at this point whose upper side is over `height_mm`.
  std::function<std::optional<std::string>(const Eigen::Vector2d& point_m, double height_mm)> box;
};

class LiftBody {
 public:
  explicit LiftBody(const FieldSpec& field);

  // They return the reason when the command is refused.
  std::optional<std::string> Drive(const Eigen::Vector3d& velocity, Duration now);
  std::optional<std::string> Lift(const WheelHeights& heights_mm);

  // Stands there at rest. Returns the reason when a corner would stand on another platform.
  std::optional<std::string> PutDown(const FieldSpec& field, const Eigen::Vector2d& at_m,
                                     double yaw_rad);

  struct Stuck {
    bool wheels = false;
    bool base = false;
  };
  // Returns a line for the log when it bumps or falls.
  std::optional<std::string> Step(const LiftPlace& place, const Stuck& stuck, Duration now,
                                  Duration dt);

  const Eigen::Vector2d& position_m() const { return position_m_; }
  double yaw_rad() const { return yaw_rad_; }
  // In the frame of the body.
  Eigen::Vector3d velocity() const { return velocity_; }
  const WheelHeights& wheels_mm() const { return wheels_mm_; }
  const WheelHeights& targets_mm() const { return targets_mm_; }
  // Of the middle of its underside over the ground of the field.
  double height_mm() const;
  bool waits() const { return waits_; }  // a platform blocks it that it is about to climb
  bool fallen() const { return !fall_.empty(); }
  const std::string& fall() const { return fall_; }  // why
  int bumps() const { return bumps_; }
  int falls() const { return falls_; }

  // What its sensors measure.
  std::array<bool, kLiftWheels> Switches(const FieldSpec& field) const;
  std::array<double, kLiftRangers> DistancesMm(const FieldSpec& field) const;

 private:
  struct Pose {
    Eigen::Vector2d position_m;
    double yaw_rad;
  };
  // What stops the body at a pose.
  struct Block {
    std::string what;
    bool waits = false;
  };

  static Eigen::Vector2d InPlace(const Pose& pose, const Eigen::Vector2d& point_m);
  Pose pose() const { return {position_m_, yaw_rad_}; }
  double UndersideMm(const Eigen::Vector2d& point_m) const;  // of the plate at a point of the body
  void Support(const FieldSpec& field);
  bool Hangs(const FieldSpec& field, std::size_t wheel) const;
  bool MoveWheels(const FieldSpec& field, double seconds);
  std::optional<Block> Blocked(const LiftPlace& place, const Pose& at) const;
  std::optional<Block> Move(const LiftPlace& place, double seconds);
  std::optional<std::string> CheckFall();

  LiftSpec spec_;
  Eigen::Vector2d position_m_;
  double yaw_rad_;
  Eigen::Vector3d velocity_{0, 0, 0};
  Eigen::Vector3d command_{0, 0, 0};
  std::optional<Duration> commanded_at_;
  WheelHeights wheels_mm_{};
  WheelHeights targets_mm_{};
  WheelHeights corners_mm_{};  // of the underside at each wheel, over the field's ground
  bool waits_ = false;
  std::optional<Eigen::Vector2d> touched_m_;  // where it touched something last
  std::string fall_;
  int bumps_ = 0;
  int falls_ = 0;
};

}  // namespace musher::world
