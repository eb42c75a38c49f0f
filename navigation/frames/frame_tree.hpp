#pragma once
// How frames lie in each other, as ROS 2 has it on /tf and /tf_static: where the frame of the
// odometry is in the map, and a scanner on the body.
//
// Each frame has one parent. Of a transform the last one counts, whatever its stamp: a localisation
// dates them ahead. One of /tf that has not come for `stale` is not used. Numbers that are not
// finite, rotations without a length, and frames without a name are refused. Metres, radians. Pure;
// one thread.

#include <map>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation {

// Where the child is in its parent.
struct FrameTransform {
  Point origin;
  double x = 0, y = 0, z = 0, w = 1;  // the rotation, a quaternion
};

// The same for frames that stand upright in each other, or upside down.
struct FramePlacement {
  Pose pose;  // yaw: where its x axis points
  bool upside_down = false;
};

class FrameTree {
 public:
  explicit FrameTree(Duration stale) : stale_(stale) {}

  // Of a topic; false: refused.
  bool Set(std::string_view parent, std::string_view child, const FrameTransform& transform,
           bool fixed, Time now);
  // The same of a tf2_msgs/TFMessage.
  template <class TfMessage>
  void Take(const TfMessage& message, bool fixed, Time now) {
    for (const auto& one : message.transforms) {
      const auto& t = one.transform.translation;
      const auto& r = one.transform.rotation;
      Set(one.header.frame_id, one.child_frame_id, {{t.x, t.y, t.z}, r.x, r.y, r.z, r.w}, fixed,
          now);
    }
  }
  // The time was set: only fixed ones stay.
  void Forget();

  // Where `child` is in `parent`, along the parents of `child`. Fails, with the reason, where there
  // is no recent transform, and where the one is tilted in the other.
  Result<FramePlacement> Find(std::string_view parent, std::string_view child, Time now) const;

 private:
  struct Frame {
    std::string parent;
    FrameTransform transform;
    bool fixed = false;
    Time at{};
  };

  const Duration stale_;
  std::map<std::string, Frame, std::less<>> frames_;  // by the name of the child
};

}  // namespace musher::navigation
