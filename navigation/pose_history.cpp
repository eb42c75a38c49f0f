#include "musher/navigation/pose_history.hpp"

#include <algorithm>
#include <chrono>

namespace musher::navigation {
namespace {

constexpr Duration kKept = std::chrono::seconds(1);
constexpr Duration kStampsSetBack = std::chrono::seconds(1);  // a larger step back of stamps
constexpr std::size_t kMostPoses = 2000;

}  // namespace

bool PoseHistory::Add(const Pose& pose, Duration stamp) {
  if (!poses_.empty() && stamp != Duration::zero()) {
    const Duration step = stamp - poses_.back().stamp;
    if (step <= Duration::zero() && step > -kStampsSetBack) return false;
    if (step < Duration::zero()) poses_.clear();
  }
  poses_.push_back({stamp, pose});
  while (poses_.front().stamp < stamp - kKept || poses_.size() > kMostPoses) poses_.pop_front();
  return true;
}

const Pose& PoseHistory::At(Duration stamp) const {
  if (stamp == Duration::zero()) return poses_.back().pose;
  const auto away = [&](const Stamped& one) { return std::chrono::abs(one.stamp - stamp); };
  // Of two that are as near the later one.
  return std::ranges::min_element(poses_.rbegin(), poses_.rend(), {}, away)->pose;
}

}  // namespace musher::navigation
