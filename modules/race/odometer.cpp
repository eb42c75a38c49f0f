#include "musher/modules/race/odometer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace musher::race {
namespace {

// The most that a body moves between two samples, beside what their distance in time permits.
constexpr double kJumpM = 0.1;
constexpr double kJumpRad = 0.3;
constexpr double kFastestMS = 3;
constexpr double kFastestRadS = 6;

std::string Fixed(const char* format, double number) {
  char text[64];
  std::snprintf(text, sizeof text, format, number);
  return text;
}

}  // namespace

void Odometer::Begin(Duration now) {
  pose_.reset();
  stamp_ns_.reset();
  moved_ = {};
  is_new_ = frozen_ = is_still_ = false;
  received_at_ = now;
  still_from_ = still_at_ = now + rules_.begin;
  late_.reset();
  jump_.clear();
  doubt_.clear();
}

void Odometer::OnSample(std::int64_t stamp_ns, const navigation::Pose& pose, Duration age) {
  if (!jump_.empty()) return;
  late_.reset();
  if (age > rules_.fresh) late_ = age;
  frozen_ = stamp_ns_ == stamp_ns;
  if (late_ || frozen_) return;
  const bool is_same = pose_ && pose.at.x_m == pose_->at.x_m && pose.at.y_m == pose_->at.y_m &&
                       pose.yaw_rad == pose_->yaw_rad;
  if (is_same && stamp_ns > *stamp_ns_) {
    stamp_ns_ = stamp_ns;
    is_still_ = true;
    return;
  }
  const navigation::Pose before = pose_.value_or(pose);
  const double seconds = !pose_                  ? 0
                         : stamp_ns < *stamp_ns_ ? ToSeconds(Duration(stamp_ns - *stamp_ns_))
                                                 : ToSeconds(Duration(stamp_ns - pose_stamp_ns_));
  pose_ = pose;
  stamp_ns_ = stamp_ns;
  pose_stamp_ns_ = stamp_ns;
  const double x_m = pose.at.x_m - before.at.x_m;
  const double y_m = pose.at.y_m - before.at.y_m;
  const double yaw_rad = navigation::Wrapped(pose.yaw_rad - before.yaw_rad);
  if (seconds < 0) {
    jump_ = "the stamps of the odometry go back by " + Fixed("%.2f s", -seconds);
  } else if (std::hypot(x_m, y_m) > kJumpM + kFastestMS * seconds) {
    jump_ = "the odometry jumps by " + Fixed("%.2f m", std::hypot(x_m, y_m));
  } else if (std::abs(yaw_rad) > kJumpRad + kFastestRadS * seconds) {
    jump_ = "the odometry jumps by " + Fixed("%.0f degrees", std::abs(yaw_rad) * 180 / M_PI);
  }
  if (!jump_.empty()) return;
  const double middle_rad = before.yaw_rad + yaw_rad / 2;
  moved_.forward_m += x_m * std::cos(middle_rad) + y_m * std::sin(middle_rad);
  moved_.left_m += y_m * std::cos(middle_rad) - x_m * std::sin(middle_rad);
  moved_.yaw_rad += yaw_rad;
  is_new_ = true;
}

std::optional<Displacement> Odometer::Take(Duration now) {
  if (!jump_.empty()) {
    doubt_ = jump_;
    return std::nullopt;
  }
  const bool is_still = std::exchange(is_still_, false);
  if (std::exchange(is_new_, false)) {
    received_at_ = now;
    still_from_ = still_at_ = std::max(now, still_from_);
    doubt_.clear();
    return std::exchange(moved_, {});
  }
  if (is_still) {
    received_at_ = now;
    still_at_ = std::max(now, still_from_);
  }
  if (now - received_at_ < rules_.fresh || !believed()) return std::nullopt;
  doubt_ = WhySilent();
  pose_.reset();  // what it moves until the next sample is counted by time
  return std::nullopt;
}

std::string Odometer::WhySilent() const {
  if (late_) return "the odometry is " + Fixed("%.1f s", ToSeconds(*late_)) + " old";
  if (frozen_) return "the stamps of the odometry stand still";
  return "no odometry on " + rules_.topic + " for " + std::to_string(ToMilliseconds(rules_.fresh)) +
         " ms";
}

}  // namespace musher::race
