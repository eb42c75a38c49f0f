#pragma once
// From the detections in successive pictures to what is published: which persons are present, which
// one to look at, whether a person is too close. Pure: time is the pictures' own.

#include <cstdint>
#include <optional>
#include <vector>

#include "musher/modules/vision/faces/closeness.hpp"
#include "musher/modules/vision/faces/face_tracker.hpp"
#include "musher/modules/vision/faces/target_choice.hpp"
#include "musher/modules/vision/picture/lens.hpp"

namespace musher::vision {

struct FaceRules {
  double face_m = 0.18;  // height of what the detector's box encloses
  TrackerRules tracker;
  TargetRules target;
  ClosenessRules closeness;

  friend bool operator==(const FaceRules&, const FaceRules&) = default;
};

// The result of one picture.
struct Sight {
  struct Face {
    int id = 0;
    FaceBox box;
    std::optional<double> distance_m;  // nothing: the lens is unknown
  };
  std::int64_t stamp_ns = 0;
  std::vector<Face> faces;        // confirmed ones that are seen in it
  std::optional<Face> target;     // one of them
  std::optional<bool> too_close;  // nothing: the lens is unknown, or no face was seen yet
};

class FaceWatch {
 public:
  explicit FaceWatch(const FaceRules& rules)
      : rules_(rules), tracker_(rules.tracker), target_(rules.target), near_(rules.closeness) {}

  // `stamp_ns` is later than that of the picture before. Without a lens the distance of a face is
  // unknown; the largest one is still the nearest.
  Sight OnPicture(std::int64_t stamp_ns, const std::vector<FaceBox>& boxes,
                  const std::optional<Lens>& lens);

 private:
  FaceRules rules_;
  FaceTracker tracker_;
  TargetChoice target_;
  Closeness near_;
};

}  // namespace musher::vision
