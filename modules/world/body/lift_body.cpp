#include "musher/modules/world/body/lift_body.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPlateM = 0.295;     // of the underside that can rest on a platform
constexpr int kPlateParts = 4;        // of a quarter of it along each side
constexpr int kHullParts = 6;         // of a side of the hull
constexpr double kLegM = 0.01;        // half the width of a wheel's leg
constexpr double kRollMm = 25;        // a wheel rolls over such an edge
constexpr double kGrazeMm = 3;        // the hull slides over such an edge
constexpr double kHangMm = 2;         // a wheel that is so far over the ground hangs
constexpr double kCreepMps = 0.1;     // while a wheel hangs
constexpr double kMostTiltMm = 100;   // between opposite wheels
constexpr double kBumpApartM = 0.05;  // after so far it can bump again
constexpr double kSwitchSpotM = 0.02;
constexpr double kSwitchMm = 60;
constexpr double kRangerM = 0.285;  // from the centre to a ranger that looks down
constexpr double kRangerSpotM = 0.01;
constexpr double kRangerMm = 10;  // over the underside
constexpr double kMostRangeMm = 2000;
constexpr double kRayM = 0.01;

constexpr std::array<std::pair<int, int>, kLiftWheels> kSigns{{{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};

Vector2d WheelAt(std::size_t wheel) {
  return kLiftWheelM * Vector2d(kSigns.at(wheel).first, kSigns.at(wheel).second);
}

// Front, left, rear, right.
Vector2d SideOf(std::size_t side) {
  constexpr std::array<std::pair<int, int>, 4> kSides{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  return {kSides.at(side).first, kSides.at(side).second};
}

// Along the edge of the hull.
std::array<Vector2d, 4 * kHullParts> HullPoints() {
  std::array<Vector2d, 4 * kHullParts> points;
  for (std::size_t side = 0; side < 4; ++side) {
    const Vector2d out = SideOf(side);
    const Vector2d along(-out.y(), out.x());
    for (int part = 0; part < kHullParts; ++part) {
      const double at = 2.0 * part / kHullParts - 1;
      points.at(side * kHullParts + static_cast<std::size_t>(part)) =
          kLiftHalfM * (out + at * along);
    }
  }
  return points;
}

double LiftTowards(double from, double to, double most) {
  return from + std::clamp(to - from, -most, most);
}

}  // namespace

LiftBody::LiftBody(const FieldSpec& field)
    : spec_(field.robot), position_m_(spec_.start_m), yaw_rad_(spec_.start_yaw_rad) {
  wheels_mm_.fill(spec_.rest_mm);
  targets_mm_ = wheels_mm_;
  Support(field);
}

std::optional<std::string> LiftBody::Drive(const Vector3d& velocity, Duration now) {
  if (!velocity.allFinite()) return "a velocity that is not a number is refused";
  command_ = velocity;
  commanded_at_ = now;
  return std::nullopt;
}

std::optional<std::string> LiftBody::Lift(const WheelHeights& heights_mm) {
  for (const double height : heights_mm) {
    if (!std::isfinite(height)) return "a wheel height that is not a number is refused";
  }
  for (std::size_t i = 0; i < kLiftWheels; ++i) {
    targets_mm_.at(i) = std::clamp(heights_mm.at(i), 0.0, spec_.most_mm);
  }
  return std::nullopt;
}

std::optional<std::string> LiftBody::PutDown(const FieldSpec& field, const Vector2d& at_m,
                                             double yaw_rad) {
  if (!at_m.allFinite() || !std::isfinite(yaw_rad))
    return "a place that is not a number is refused";
  const Pose at{at_m, std::remainder(yaw_rad, 2 * M_PI)};
  const double floor_mm = field.HeightMm(at_m);
  for (const Vector2d& point : HullPoints()) {
    if (field.HeightMm(InPlace(at, point)) == floor_mm) continue;
    return "it would be on an edge";
  }
  position_m_ = at.position_m;
  yaw_rad_ = at.yaw_rad;
  velocity_ = {0, 0, 0};
  commanded_at_.reset();
  wheels_mm_.fill(spec_.rest_mm);
  targets_mm_ = wheels_mm_;
  fall_.clear();
  waits_ = false;
  touched_m_.reset();
  Support(field);
  return std::nullopt;
}

std::optional<std::string> LiftBody::Step(const LiftPlace& place, const Stuck& stuck, Duration now,
                                          Duration dt) {
  if (fallen()) return std::nullopt;
  const double seconds = ToSeconds(dt);
  const bool held = !stuck.wheels && MoveWheels(place.field, seconds);
  Vector3d target(0, 0, 0);
  if (commanded_at_ && now - *commanded_at_ <= spec_.command_timeout && !stuck.base) {
    target = command_;
  }
  const double speed = target.head<2>().norm();
  if (speed > spec_.speed_m_s) target.head<2>() *= spec_.speed_m_s / speed;
  target.z() = std::clamp(target.z(), -spec_.turn_rad_s, spec_.turn_rad_s);
  const Vector2d change = target.head<2>() - velocity_.head<2>();
  const double most = spec_.acceleration_m_s2 * seconds;
  velocity_.head<2>() += change.norm() > most ? Vector2d(change * (most / change.norm())) : change;
  velocity_.z() = LiftTowards(velocity_.z(), target.z(), spec_.turn_acceleration_rad_s2 * seconds);
  bool hangs = false;
  for (std::size_t i = 0; i < kLiftWheels; ++i) hangs = hangs || Hangs(place.field, i);
  const double moves = velocity_.head<2>().norm();
  if (hangs && moves > kCreepMps) velocity_.head<2>() *= kCreepMps / moves;
  if (held) velocity_ = {0, 0, 0};

  const std::optional<Block> block = Move(place, seconds);
  waits_ = block && block->waits;
  const bool bumps = block && !block->waits;
  const bool bumped = bumps && (!touched_m_ || (position_m_ - *touched_m_).norm() > kBumpApartM);
  if (bumps) touched_m_ = position_m_;
  Support(place.field);
  if (auto fall = CheckFall()) return fall;
  if (!bumped) return std::nullopt;
  ++bumps_;
  return "the robot bumped into " + block->what;
}

double LiftBody::height_mm() const {
  return UndersideMm({0, 0});
}

Vector2d LiftBody::InPlace(const Pose& pose, const Vector2d& point_m) {
  return pose.position_m + Rotation2Dd(pose.yaw_rad) * point_m;
}

double LiftBody::UndersideMm(const Vector2d& point_m) const {
  const double front = 0.5 + point_m.x() / (2 * kLiftWheelM);
  const double left = 0.5 + point_m.y() / (2 * kLiftWheelM);
  return front * (left * corners_mm_[0] + (1 - left) * corners_mm_[1]) +
         (1 - front) * (left * corners_mm_[2] + (1 - left) * corners_mm_[3]);
}

// Each corner stands on its wheel, or on a platform below its quarter of the plate.
void LiftBody::Support(const FieldSpec& field) {
  for (std::size_t i = 0; i < kLiftWheels; ++i) {
    double highest = field.HeightMm(InPlace(pose(), WheelAt(i))) + wheels_mm_.at(i);
    for (int x = 0; x <= kPlateParts; ++x) {
      for (int y = 0; y <= kPlateParts; ++y) {
        const Vector2d point(kSigns.at(i).first * x, kSigns.at(i).second * y);
        highest =
            std::max(highest, field.HeightMm(InPlace(pose(), point * (kPlateM / kPlateParts))));
      }
    }
    corners_mm_.at(i) = highest;
  }
}

bool LiftBody::Hangs(const FieldSpec& field, std::size_t wheel) const {
  const double below_mm = corners_mm_.at(wheel) - wheels_mm_.at(wheel);
  return below_mm > field.HeightMm(InPlace(pose(), WheelAt(wheel))) + kHangMm;
}

// Returns whether a hanging wheel extended.
bool LiftBody::MoveWheels(const FieldSpec& field, double seconds) {
  bool extended = false;
  for (std::size_t i = 0; i < kLiftWheels; ++i) {
    double& height = wheels_mm_.at(i);
    const double target = targets_mm_.at(i);
    extended = extended || (target > height && Hangs(field, i));
    height = LiftTowards(height, target, spec_.wheel_mm_s * seconds);
  }
  Support(field);
  return extended;
}

// Only what is higher than the ground that the same point was on: nothing blocks the way back.
std::optional<LiftBody::Block> LiftBody::Blocked(const LiftPlace& place, const Pose& at) const {
  const auto edge = [&](const Vector2d& point, double clear_mm) -> std::optional<double> {
    const double height = place.field.HeightMm(InPlace(at, point));
    if (height <= clear_mm || height <= place.field.HeightMm(InPlace(pose(), point))) {
      return std::nullopt;
    }
    return height;
  };
  double highest_mm = 0;  // of the underside, as commanded
  for (std::size_t i = 0; i < kLiftWheels; ++i) {
    highest_mm = std::max(highest_mm, place.field.HeightMm(InPlace(pose(), WheelAt(i))) +
                                          targets_mm_.at(i) + kGrazeMm);
  }
  for (const Vector2d& point : HullPoints()) {
    const double underside = UndersideMm(point);
    if (const auto height = edge(point, underside + kGrazeMm)) {
      return Block{"a platform of " + std::to_string(std::lround(*height)) + " mm",
                   *height <= highest_mm};
    }
    const auto box = place.box(InPlace(at, point), underside);
    if (box && box != place.box(InPlace(pose(), point), underside)) return Block{*box};
  }
  for (std::size_t i = 0; i < kLiftWheels; ++i) {
    const double below = corners_mm_.at(i) - wheels_mm_.at(i);
    for (std::size_t side = 0; side < 4; ++side) {
      if (edge(WheelAt(i) + kLegM * SideOf(side), below + kRollMm)) return Block{"an edge", true};
    }
  }
  return std::nullopt;
}

// As far as it can: it slides along what blocks it. Returns what did.
std::optional<LiftBody::Block> LiftBody::Move(const LiftPlace& place, double seconds) {
  const Vector2d way = Rotation2Dd(yaw_rad_) * velocity_.head<2>() * seconds;
  const double turn = velocity_.z() * seconds;
  std::optional<Block> found;
  if (const Pose turned{position_m_, std::remainder(yaw_rad_ + turn, 2 * M_PI)}; turn != 0) {
    found = Blocked(place, turned);
    if (found) velocity_.z() = 0;
    if (!found) yaw_rad_ = turned.yaw_rad;
  }
  for (const Vector2d& part : {way, Vector2d(way.x(), 0), Vector2d(0, way.y())}) {
    if (part.isZero(0)) continue;
    const auto block = Blocked(place, {position_m_ + part, yaw_rad_});
    if (!block) {
      position_m_ += part;
      if (part != way) {
        velocity_.head<2>() = Rotation2Dd(-yaw_rad_) * Vector2d(part / seconds);
      }
      return found;
    }
    if (!found || (found->waits && !block->waits)) found = block;
  }
  if (!way.isZero(0)) velocity_.head<2>().setZero();
  return found;
}

std::optional<std::string> LiftBody::CheckFall() {
  const auto& z = corners_mm_;
  const double ahead = (z[0] + z[1] - z[2] - z[3]) / 2;
  const double aside = (z[0] + z[2] - z[1] - z[3]) / 2;
  if (std::max(std::abs(ahead), std::abs(aside)) <= kMostTiltMm) return std::nullopt;
  const char* side = std::abs(ahead) > std::abs(aside) ? (ahead < 0 ? "front" : "rear")
                                                       : (aside < 0 ? "left" : "right");
  ++falls_;
  velocity_ = {0, 0, 0};
  fall_ = std::string("the ") + side + " wheels had nothing to stand on";
  return "the robot fell: " + fall_;
}

std::array<bool, kLiftWheels> LiftBody::Switches(const FieldSpec& field) const {
  std::array<bool, kLiftWheels> on{};
  for (std::size_t i = 0; i < kLiftWheels; ++i) {
    double highest = field.HeightMm(InPlace(pose(), WheelAt(i)));
    for (std::size_t side = 0; side < 4; ++side) {
      const Vector2d point = WheelAt(i) + kSwitchSpotM * SideOf(side);
      highest = std::max(highest, field.HeightMm(InPlace(pose(), point)));
    }
    on.at(i) = corners_mm_.at(i) - highest <= kSwitchMm;
  }
  return on;
}

std::array<double, kLiftRangers> LiftBody::DistancesMm(const FieldSpec& field) const {
  std::array<double, kLiftRangers> distances{};
  for (std::size_t side = 0; side < 4; ++side) {
    const Vector2d out = SideOf(side);
    double down = kMostRangeMm;
    for (const double spot : {-kRangerSpotM, 0.0, kRangerSpotM}) {
      const Vector2d point = out * (kRangerM + spot);
      down =
          std::min(down, UndersideMm(point) + kRangerMm - field.HeightMm(InPlace(pose(), point)));
    }
    distances.at(2 * side) = std::max(down, 0.0);

    const double eye_mm = UndersideMm(out * kLiftHalfM) + kRangerMm;
    const int rays = static_cast<int>(kMostRangeMm / 1000 / kRayM);
    double ahead = kMostRangeMm;
    for (int i = 0; i < rays && ahead == kMostRangeMm; ++i) {
      const double far_m = i * kRayM;
      if (field.HeightMm(InPlace(pose(), out * (kLiftHalfM + far_m))) < eye_mm) continue;
      ahead = std::max(far_m * 1000, 1.0);
    }
    distances.at(2 * side + 1) = ahead;
  }
  return distances;
}

}  // namespace musher::world
