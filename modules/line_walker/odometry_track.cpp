#include "musher/modules/line_walker/odometry_track.hpp"

#include <algorithm>
#include <cmath>

#include "musher/messages/stamp.hpp"
#include "musher/messages/yaw.hpp"

namespace musher::line_walker {
namespace {

constexpr std::int64_t kKeptNs = 3'000'000'000;
// A stamp that much newer than the newest sample, or older than the oldest, is of another clock.
constexpr std::int64_t kNewerNs = 500'000'000;
constexpr std::int64_t kOlderNs = 60'000'000'000;
// The most that a body moves between two samples: at most kFarthestM, and beside what their
// distance in time permits.
constexpr double kFarthestM = 0.5;
constexpr double kJumpM = 0.1;
constexpr double kJumpRad = 0.3;
constexpr double kFastestMS = 3;
constexpr double kFastestRadS = 6;

std::optional<Pose> PoseOf(const msg::Odometry& odometry) {
  const auto& at = odometry.pose.pose.position;
  const auto& turn = odometry.pose.pose.orientation;
  const double norm = turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + turn.w * turn.w;
  if (!std::isfinite(at.x) || !std::isfinite(at.y) || !(norm > 0.5 && norm < 2)) {
    return std::nullopt;
  }
  return Pose{at.x, at.y, msg::YawOf(turn)};
}

double Finite(double value) {
  return std::isfinite(value) ? value : 0;
}

Pose Between(const Pose& a, const Pose& b, double share) {
  return {a.x_m + share * (b.x_m - a.x_m), a.y_m + share * (b.y_m - a.y_m),
          a.yaw_rad + share * Wrapped(b.yaw_rad - a.yaw_rad)};
}

}  // namespace

double Wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * M_PI);
}

Pose Moved(const Pose& pose, const Velocity& velocity, double seconds) {
  const double yaw = pose.yaw_rad + velocity.yaw_rad_s * seconds / 2;
  return {pose.x_m +
              seconds * (velocity.forward_m_s * std::cos(yaw) - velocity.left_m_s * std::sin(yaw)),
          pose.y_m +
              seconds * (velocity.forward_m_s * std::sin(yaw) + velocity.left_m_s * std::cos(yaw)),
          pose.yaw_rad + velocity.yaw_rad_s * seconds};
}

OdometryTrack::Taken OdometryTrack::Take(const msg::Odometry& odometry) {
  const auto pose = PoseOf(odometry);
  if (!pose) return Taken::kInvalid;
  const auto& twist = odometry.twist.twist;
  const std::int64_t stamp_ns = msg::FromStamp(odometry.header.stamp).count();
  Taken taken = Taken::kGood;
  if (!samples_.empty()) {
    const Sample& last = samples_.back();
    if (stamp_ns == last.stamp_ns) return Taken::kAgain;
    const double seconds = double(stamp_ns - last.stamp_ns) * 1e-9;
    const double moved_m = std::hypot(pose->x_m - last.pose.x_m, pose->y_m - last.pose.y_m);
    const double turned_rad = std::abs(Wrapped(pose->yaw_rad - last.pose.yaw_rad));
    if (seconds < 0 || moved_m > std::min(kFarthestM, kJumpM + kFastestMS * seconds) ||
        turned_rad > kJumpRad + kFastestRadS * seconds) {
      samples_.clear();
      taken = Taken::kJump;
    }
  }
  samples_.push_back(
      {stamp_ns, *pose, {Finite(twist.linear.x), Finite(twist.linear.y), Finite(twist.angular.z)}});
  while (samples_.front().stamp_ns < stamp_ns - kKeptNs) samples_.pop_front();
  return taken;
}

std::optional<Duration> OdometryTrack::AgeOf(std::int64_t stamp_ns) const {
  const std::int64_t oldest = samples_.front().stamp_ns;
  const std::int64_t newest = samples_.back().stamp_ns;
  const bool other_clock = stamp_ns < oldest - kOlderNs || stamp_ns > newest + kNewerNs;
  if (stamp_ns == 0 || other_clock) return std::nullopt;
  return Duration(newest - stamp_ns);
}

Pose OdometryTrack::At(Duration age) const {
  const std::int64_t stamp_ns = samples_.back().stamp_ns - std::max(age, Duration(0)).count();
  const auto after = std::lower_bound(
      samples_.begin(), samples_.end(), stamp_ns,
      [](const Sample& sample, std::int64_t stamp) { return sample.stamp_ns < stamp; });
  if (after == samples_.begin()) return after->pose;
  const Sample& before = *std::prev(after);
  const auto span = double(after->stamp_ns - before.stamp_ns);
  return Between(before.pose, after->pose, double(stamp_ns - before.stamp_ns) / span);
}

}  // namespace musher::line_walker
