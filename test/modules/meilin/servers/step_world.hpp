#pragma once
// A body on four wheels of variable height before one step, in one dimension: where the wheels and
// the hull stand, what blocks the base, what the sensors see. The geometry is that of README.md of
// the servers. Metres for positions, millimetres for heights.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "musher/modules/meilin/servers/suspension.hpp"

namespace musher::meilin::servers::testing {

class StepWorld {
 public:
  // `height_mm` above 0: a step up at 0 m, below 0: a step down. The body begins 0.6 m before it.
  StepWorld(double height_mm, ClimbDirection direction) : step_mm_(height_mm) {
    // Corners by their place in the body, x ahead and y to the left.
    constexpr std::array<std::array<int, 2>, 4> kPlaces = {{{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
    constexpr std::array<std::array<int, 2>, 4> kAheads = {{{1, 0}, {0, 1}, {0, -1}, {-1, 0}}};
    constexpr std::array<std::size_t, 4> kSideAhead = {0, 2, 6, 4};
    constexpr std::array<std::size_t, 4> kSideBehind = {4, 6, 2, 0};
    const auto way = static_cast<std::size_t>(direction);
    for (std::size_t i = 0; i < 4; ++i) {
      front_[i] = kPlaces[i][0] * kAheads[way][0] + kPlaces[i][1] * kAheads[way][1] > 0;
    }
    ahead_ = kSideAhead[way];
    behind_ = kSideBehind[way];
    heights_.fill(20);
  }

  // 10 ms: the wheels follow their targets, the base drives on as far as it can.
  void Step(const std::optional<WheelHeights>& targets, double speed_m_s = 0.3) {
    bool extends = false;
    for (std::size_t i = 0; targets && i < kWheels; ++i) {
      const double to = std::clamp((*targets)[i], 0.0, 420.0);
      const double by = std::clamp(to - heights_[i], -4.0, 4.0);
      heights_[i] += by;
      extends = extends || (by > 0 && Hangs(front_[i]));
    }
    const bool hangs = Hangs(true) || Hangs(false);
    if (extends) return;
    const double next_m = x_m_ + 0.01 * (hangs ? std::min(speed_m_s, 0.1) : speed_m_s);
    if (Blocked(next_m)) return;
    x_m_ = next_m;
    if (x_m_ > 0 && step_mm_ < 0 && Hangs(true)) fallen_ = true;
  }

  // What the hardware reports.
  void Report(Suspension& core, Time now) const {
    std::array<bool, kWheels> switches{};
    for (std::size_t i = 0; i < kWheels; ++i) switches[i] = SwitchOn(front_[i]);
    core.OnChassis(switches, heights_, now);
    core.OnDistances(Distances(), now);
  }
  std::array<double, kDistances> Distances() const {
    std::array<double, kDistances> mm{};
    mm.fill(2000);
    mm[ahead_] = Underside(true) - Ground(x_m_ + 0.285);
    mm[behind_] = Underside(false) - Ground(x_m_ - 0.285);
    const bool riser = step_mm_ > 0 && x_m_ + 0.3 < 0 && step_mm_ > Underside(true) + 10;
    if (riser) mm[ahead_ + 1] = std::max(1.0, 1000 * -(x_m_ + 0.3));
    return mm;
  }

  double x_m() const { return x_m_; }
  bool fallen() const { return fallen_; }
  const WheelHeights& heights() const { return heights_; }

 private:
  double Ground(double x_m) const {
    const bool beyond = x_m >= 0;
    return step_mm_ > 0 ? (beyond ? step_mm_ : 0) : (beyond ? 0 : -step_mm_);
  }
  double Wheel(bool front) const {
    for (std::size_t i = 0; i < kWheels; ++i) {
      if (front_[i] == front) return heights_[i];
    }
    return 0;
  }
  double At(bool front) const { return x_m_ + (front ? 0.25 : -0.25); }
  // The height of the hull's underside: it rests on its wheels or on what is below it.
  double Underside(bool front) const {
    const double edge_m = x_m_ + (front ? 0.295 : -0.295);
    const double below = std::max(Ground(edge_m), Ground(x_m_));
    return std::max(Ground(At(front)) + Wheel(front), below);
  }
  bool Hangs(bool front) const { return Underside(front) - Wheel(front) > Ground(At(front)) + 5; }
  bool SwitchOn(bool front) const {
    const double surface = std::max(Ground(At(front) - 0.02), Ground(At(front) + 0.02));
    return Underside(front) - surface <= 60;
  }
  bool Blocked(double next_m) const {
    constexpr double kRollsOverMm = 25;
    if (Ground(next_m + 0.3) > Underside(true)) return true;
    for (const bool front : {true, false}) {
      const double wheel_m = next_m + (front ? 0.26 : -0.24);
      if (Ground(wheel_m) > Underside(front) - Wheel(front) + kRollsOverMm) return true;
    }
    return false;
  }

  const double step_mm_;
  std::array<bool, 4> front_{};
  std::size_t ahead_ = 0;
  std::size_t behind_ = 0;
  WheelHeights heights_{};
  double x_m_ = -0.6;
  bool fallen_ = false;
};

}  // namespace musher::meilin::servers::testing
