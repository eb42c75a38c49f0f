#pragma once
// A robot on a small field for tests, and the sequence of wheel heights that brings it over an
// edge, driven by the sensors of the field alone.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "musher/modules/world/simulation/field.hpp"

namespace musher::world {

// A row of platforms along x, one column: the first one at (0, 0).
inline FieldSpec Stairs(const std::vector<double>& heights_mm) {
  FieldSpec field;
  field.rows = static_cast<int>(heights_mm.size());
  field.cols = 1;
  field.origin_m = {0, 0};
  field.heights_mm = heights_mm;
  return field;
}

// Forward, left, right, backward: the order of wheels and distances as seen in that direction, and
// the direction itself in the frame of the body.
struct ClimbSide {
  std::array<std::size_t, 4> wheels;
  std::array<std::size_t, 4> distances;
  Eigen::Vector2d way;
};
inline const std::array<ClimbSide, 4>& ClimbSides() {
  static const std::array<ClimbSide, 4> kSides{{{{0, 1, 2, 3}, {0, 1, 5, 4}, {1, 0}},
                                                {{2, 0, 3, 1}, {2, 3, 7, 6}, {0, 1}},
                                                {{1, 3, 0, 2}, {6, 7, 3, 2}, {0, -1}},
                                                {{3, 2, 1, 0}, {4, 5, 1, 0}, {-1, 0}}}};
  return kSides;
}

class Climber {
 public:
  explicit Climber(FieldSpec spec) : field_(std::move(spec)) {}

  Field& field() { return field_; }
  const LiftBody& robot() const { return field_.robot(); }
  const FieldReading& reading() const { return field_.readings().back(); }
  const std::vector<std::string>& log() const { return log_; }
  std::set<std::string>& faults() { return faults_; }

  // One step of 20 ms of the world with the present command.
  void Step() {
    now_ += Milliseconds(20);
    if (driven_) static_cast<void>(field_.Drive(velocity_, now_));
    for (const std::string& line : field_.Step(faults_, now_, Milliseconds(20))) {
      log_.push_back(line);
    }
  }
  void Drive(const Eigen::Vector3d& velocity) {
    velocity_ = velocity;
    driven_ = true;
  }
  void ReleaseControl() { driven_ = false; }
  void Lift(double all_mm) { static_cast<void>(field_.Lift({all_mm, all_mm, all_mm, all_mm})); }
  // Steps until it holds; false after 10 s.
  bool Until(const std::function<bool()>& holds) {
    for (int i = 0; i < 500; ++i) {
      Step();
      if (holds()) return true;
    }
    return false;
  }
  void For(double seconds) {
    for (int i = 0; i < std::lround(seconds * 50); ++i) Step();
  }
  Duration now() const { return now_; }

  // The sequence up or down, while it drives in that direction with that speed. False when a state
  // did not end.
  bool Up(const ClimbSide& side, double high_mm, double speed_m_s) {
    Head(side, speed_m_s);
    Lift(high_mm);
    return Until([&] { return Reached(side, 0, 3, high_mm); }) &&
           Until([&] { return reading().distances_mm.at(side.distances[0]) < 80; }) &&
           Pair(side, 0, 5) && Until([&] { return Both(side, 0, true); }) && Pair(side, 0, 7) &&
           Pair(side, 2, high_mm + 3) && Until([&] { return Both(side, 2, true); }) &&
           Pair(side, 2, 0) && Pair(side, 2, 3) && Rest(side);
  }
  bool Down(const ClimbSide& side, double high_mm, double speed_m_s) {
    Head(side, speed_m_s);
    return Until([&] { return Both(side, 0, false); }) && Pair(side, 0, high_mm + 30) &&
           Until([&] { return Both(side, 2, false); }) && Pair(side, 2, high_mm + 10) &&
           Until([&] { return reading().distances_mm.at(side.distances[3]) > 200; }) && Rest(side);
  }

 private:
  void Head(const ClimbSide& side, double speed_m_s) {
    Drive({side.way.x() * speed_m_s, side.way.y() * speed_m_s, 0});
  }
  bool Reached(const ClimbSide& side, std::size_t first, std::size_t last, double mm) const {
    for (std::size_t i = first; i <= last; ++i) {
      const double wanted = std::min(mm, field_.spec().robot.most_mm);
      if (std::abs(reading().wheels_mm.at(side.wheels.at(i)) - wanted) > 20) return false;
    }
    return true;
  }
  bool Both(const ClimbSide& side, std::size_t first, bool on) const {
    return reading().switches.at(side.wheels.at(first)) == on &&
           reading().switches.at(side.wheels.at(first + 1)) == on;
  }
  bool Pair(const ClimbSide& side, std::size_t first, double mm) {
    WheelHeights heights = robot().targets_mm();
    heights.at(side.wheels.at(first)) = heights.at(side.wheels.at(first + 1)) = mm;
    static_cast<void>(field_.Lift(heights));
    return Until([&] { return Reached(side, first, first + 1, mm); });
  }
  bool Rest(const ClimbSide& side) {
    Lift(20);
    return Until([&] { return Reached(side, 0, 3, 20); });
  }

  Field field_;
  Duration now_{};
  Eigen::Vector3d velocity_{0, 0, 0};
  bool driven_ = false;
  std::set<std::string> faults_;
  std::vector<std::string> log_;
};

}  // namespace musher::world
