#include "musher/navigation/frames/frame_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr std::size_t kMostFrames = 1000;
constexpr int kMostParents = 50;         // more are a circle
constexpr double kUprightCosine = 0.99;  // of the angle between the z axes: 8 degrees
constexpr std::size_t kLongestName = 100;

std::string_view WithoutSlash(std::string_view name) {
  return !name.empty() && name[0] == '/' ? name.substr(1) : name;
}

FrameTransform Turned(const FrameTransform& by, const FrameTransform& other) {
  FrameTransform turned;
  turned.w = by.w * other.w - by.x * other.x - by.y * other.y - by.z * other.z;
  turned.x = by.w * other.x + by.x * other.w + by.y * other.z - by.z * other.y;
  turned.y = by.w * other.y - by.x * other.z + by.y * other.w + by.z * other.x;
  turned.z = by.w * other.z + by.x * other.y - by.y * other.x + by.z * other.w;
  return turned;
}

Point Rotated(const FrameTransform& by, const Point& p) {
  const FrameTransform point{{}, p.x_m, p.y_m, p.z_m, 0};
  const FrameTransform back{{}, -by.x, -by.y, -by.z, by.w};
  const FrameTransform turned = Turned(Turned(by, point), back);
  return {turned.x, turned.y, turned.z};
}

// What `inner` is in the frame in which `outer` is given.
FrameTransform Composed(const FrameTransform& outer, const FrameTransform& inner) {
  FrameTransform composed = Turned(outer, inner);
  const Point at = Rotated(outer, inner.origin);
  composed.origin = {outer.origin.x_m + at.x_m, outer.origin.y_m + at.y_m,
                     outer.origin.z_m + at.z_m};
  return composed;
}

Error NoTransform(std::string_view parent, std::string_view child, const std::string& why) {
  return MakeError(Fault::kFrame,
                   fmt::format("no transform from {} to {}: {}", parent.substr(0, kLongestName),
                               child.substr(0, kLongestName), why));
}

}  // namespace

bool FrameTree::Set(std::string_view parent, std::string_view child,
                    const FrameTransform& transform, bool fixed, Time now) {
  parent = WithoutSlash(parent);
  child = WithoutSlash(child);
  const double length =
      std::hypot(std::hypot(transform.x, transform.y), std::hypot(transform.z, transform.w));
  if (parent.empty() || child.empty() || parent == child || child.size() > kLongestName ||
      parent.size() > kLongestName || !IsFinite(transform.origin) || !std::isfinite(length) ||
      length < 1e-6) {
    return false;
  }
  if (frames_.size() >= kMostFrames && frames_.find(child) == frames_.end()) return false;
  FrameTransform unit = transform;
  for (double* part : {&unit.x, &unit.y, &unit.z, &unit.w}) *part /= length;
  frames_.insert_or_assign(std::string(child), Frame{std::string(parent), unit, fixed, now});
  return true;
}

void FrameTree::Forget() {
  std::erase_if(frames_, [](const auto& named) { return !named.second.fixed; });
}

Result<FramePlacement> FrameTree::Find(std::string_view parent, std::string_view child,
                                       Time now) const {
  parent = WithoutSlash(parent);
  child = WithoutSlash(child);
  FrameTransform whole;
  std::string_view at = child;
  for (int i = 0; at != parent; ++i) {
    const auto found = frames_.find(at);
    if (found == frames_.end() || i >= kMostParents) {
      return NoTransform(parent, child,
                         fmt::format("{} has no known parent", at.substr(0, kLongestName)));
    }
    const Frame& frame = found->second;
    if (!frame.fixed && now < frame.at) {
      return NoTransform(parent, child, "the time was set back since it came");
    }
    if (!frame.fixed && now - frame.at > stale_) {
      return NoTransform(parent, child,
                         fmt::format("that of {} in {} is {:.1f} s old", at, frame.parent,
                                     ToSeconds(now - frame.at)));
    }
    whole = Composed(frame.transform, whole);
    at = frame.parent;
  }
  const Point x = Rotated(whole, {1, 0, 0}), z = Rotated(whole, {0, 0, 1});
  if (std::abs(z.z_m) < kUprightCosine) {
    return NoTransform(parent, child,
                       fmt::format("it is tilted by {:.0f} degrees",
                                   std::acos(std::clamp(std::abs(z.z_m), 0.0, 1.0)) * 180 / M_PI));
  }
  return FramePlacement{{whole.origin, std::atan2(x.y_m, x.x_m)}, z.z_m < 0};
}

}  // namespace musher::navigation
