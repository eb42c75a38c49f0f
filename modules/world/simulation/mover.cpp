#include "musher/modules/world/simulation/mover.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {

using Eigen::Vector2d;

namespace {

constexpr double kLongestBlockedS = 10;

}  // namespace

Mover::Mover(const MoverSpec& spec, std::uint64_t seed)
    : random_(seed), position_m_(spec.points_m.front()) {
  Choose(spec);
  wait_s_ = 0;
}

double Mover::Sample() {
  constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
  return static_cast<double>(random_.Next() >> 11) * kUnit;
}

// Of the next way: its direction, its speed, and the time before it.
void Mover::Choose(const MoverSpec& spec) {
  const Vector2d way = spec.points_m[next_] - position_m_;
  yaw_rad_ = std::atan2(way.y(), way.x());
  leg_m_s_ = spec.speed_m_s * (1 + spec.speed_vary * (2 * Sample() - 1));
  wait_s_ = spec.wait_s * Sample();
}

void Mover::Step(const MoverSpec& spec, const std::function<bool(const Vector2d&)>& is_free,
                 Duration dt) {
  const double seconds = ToSeconds(dt);
  speed_m_s_ = 0;
  if (wait_s_ > 0) {
    wait_s_ -= seconds;
    return;
  }
  const Vector2d way = spec.points_m[next_] - position_m_;
  const double left_m = way.norm();
  const double step_m = std::min(leg_m_s_ * seconds, left_m);
  const Vector2d to = left_m > 0 ? Vector2d(position_m_ + way * (step_m / left_m)) : position_m_;
  if (!is_free(to)) {
    blocked_s_ += seconds;
    if (blocked_s_ >= kLongestBlockedS) TurnRound(spec);
    return;
  }
  blocked_s_ = 0;
  position_m_ = to;
  speed_m_s_ = step_m / seconds;
  if (step_m < left_m) return;
  if (!spec.round_trip) {
    if (next_ == spec.points_m.size() - 1) back_ = true;
    if (next_ == 0) back_ = false;
  }
  next_ = After(spec, next_);
  Choose(spec);
}

std::size_t Mover::After(const MoverSpec& spec, std::size_t point) const {
  const std::size_t count = spec.points_m.size();
  return (point + (back_ ? count - 1 : 1)) % count;
}

void Mover::TurnRound(const MoverSpec& spec) {
  back_ = !back_;
  next_ = After(spec, next_);  // the point it came from
  Choose(spec);
  wait_s_ = blocked_s_ = 0;
}

}  // namespace musher::world
