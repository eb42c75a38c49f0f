#include "musher/navigation/pose_history.hpp"

#include <algorithm>
#include <chrono>

namespace musher::navigation {
namespace {

constexpr Duration kKept = std::chrono::seconds(1);
constexpr std::size_t kMostPoses = 2000;

}  // namespace

bool PoseHistory::Add(const Pose& pose, Duration stamp) {
  if (!order_.Take(stamp)) return false;
  const bool stamped = stamp != Duration::zero();
  if (stamped && !poses_.empty() && stamp < poses_.back().stamp) poses_.clear();
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
