#include "musher/modules/wedding/data/gaze.hpp"

#include <algorithm>
#include <cmath>

namespace musher::wedding {
namespace {

constexpr Duration kFollowStep = Milliseconds(20);
constexpr Duration kLongestStep = Milliseconds(100);

// Straight ahead for NaN: a gaze is filtered from the last one, so it would stay NaN.
double WithinPicture(double value) {
  return std::isnan(value) ? 0.5 : std::clamp(value, 0.0, 1.0);
}

}  // namespace

Gaze Follow(Gaze from, Gaze target, double follow, Duration step) {
  const Duration counted = std::clamp(step, Duration(0), kLongestStep);
  const double steps =
      static_cast<double>(counted.count()) / static_cast<double>(kFollowStep.count());
  const double share = 1 - std::pow(1 - follow, steps);
  return {WithinPicture(from.x + share * (target.x - from.x)),
          WithinPicture(from.y + share * (target.y - from.y))};
}

Gaze GazeAt(Gaze point, const HeadAngles& head, const GazeRules& rules) {
  if (rules.camera == Mount::kBody) return point;
  const double edge = std::tan(rules.hfov_rad / 2);  // of the picture, at distance 1
  const double left = head.yaw_rad - std::atan(2 * (point.x - 0.5) * edge);
  const double x = 0.5 - left / (2 * rules.yaw_limit_rad);
  if (rules.pitch_limit_rad <= 0) return {WithinPicture(x), point.y};
  const double down =
      head.pitch_rad + std::atan(2 * (point.y - 0.5) * edge * rules.height_to_width);
  return {WithinPicture(x), WithinPicture(0.5 + down / (2 * rules.pitch_limit_rad))};
}

double Nod(double pitch_rad, Gaze gaze, const GazeRules& rules, Duration step) {
  const double wanted = 2 * (gaze.y - 0.5) * rules.pitch_limit_rad;
  const double most = rules.pitch_speed_rad_s * ToSeconds(std::max(step, Duration(0)));
  return pitch_rad + std::clamp(wanted - pitch_rad, -most, most);
}

void AngleTrail::Add(Duration stamp, double angle_rad) {
  if (size_ > 0 && stamp < Back(0).stamp) size_ = 0;
  // Samples faster than the trail's spacing replace the last one.
  if (size_ >= 2 && stamp - Back(1).stamp < kSpacing) {
    next_ = (next_ + kCapacity - 1) % kCapacity;
    --size_;
  }
  ring_[next_] = {stamp, angle_rad};
  next_ = (next_ + 1) % kCapacity;
  size_ = std::min(size_ + 1, kCapacity);
}

std::optional<double> AngleTrail::At(Duration stamp) const {
  if (size_ == 0) return std::nullopt;
  if (stamp >= Back(0).stamp) return Back(0).angle_rad;
  for (std::size_t i = 1; i < size_; ++i) {
    const Entry& before = Back(i);
    if (stamp < before.stamp) continue;
    const Entry& after = Back(i - 1);
    const double share = static_cast<double>((stamp - before.stamp).count()) /
                         static_cast<double>((after.stamp - before.stamp).count());
    return before.angle_rad + share * (after.angle_rad - before.angle_rad);
  }
  return std::nullopt;
}

std::optional<double> AngleTrail::Last() const {
  if (size_ == 0) return std::nullopt;
  return Back(0).angle_rad;
}

const AngleTrail::Entry& AngleTrail::Back(std::size_t i) const {
  return ring_[(next_ + kCapacity - 1 - i) % kCapacity];
}

}  // namespace musher::wedding
