#pragma once
// Matches the faces of a picture to those of the last one. Pure: time is the pictures' own.
//
//             seen in `confirm_pictures`
//   new ────────────────────────────────────▶ confirmed ──▶ forgotten: unseen for `forget`
//    └──▶ dropped: unseen for `confirm_within`, as a false find is, and for two pictures: where
//         pictures are farther apart than that, the next one has to show it
//
// A box continues the track that it overlaps most, or else the nearest one within `distance` of
// about the same size. A number is never reused.

#include <cstdint>
#include <set>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/modules/vision/picture/face_box.hpp"

namespace musher::vision {

struct TrackerRules {
  double smallest = 0.05;  // of the picture's width, and of its height
  double iou = 0.15;       // at least, to be the same face
  double distance = 0.30;  // between the centres at most, to be the same face without overlap
  int confirm_pictures = 2;
  Duration confirm_within = Milliseconds(500);
  Duration forget = Milliseconds(5000);    // of a confirmed face
  Duration smoothing = Milliseconds(150);  // time constant of the size; zero: none

  friend bool operator==(const TrackerRules&, const TrackerRules&) = default;
};

struct Track {
  int id = 0;
  FaceBox box;        // as it was last seen
  double height = 0;  // of the box, smoothed
  std::int64_t last_ns = 0;
  int sightings = 0;
  bool confirmed = false;
  bool seen = false;  // in the last picture

  friend bool operator==(const Track&, const Track&) = default;
};

class FaceTracker {
 public:
  explicit FaceTracker(const TrackerRules& rules) : rules_(rules) {}

  // The detections of a picture, later than the one before. Tracks with an id in `kept` are not
  // forgotten.
  void OnPicture(std::int64_t stamp_ns, const std::vector<FaceBox>& boxes,
                 const std::set<int>& kept = {});

  // All tracks, confirmed or not, by id.
  const std::vector<Track>& tracks() const { return tracks_; }

 private:
  void Forget(std::int64_t stamp_ns, Duration gap, const std::set<int>& kept);
  void See(Track& track, const FaceBox& box, std::int64_t stamp_ns) const;

  TrackerRules rules_;
  std::vector<Track> tracks_;
  std::int64_t last_ns_ = 0;  // stamp of the last picture
  int next_id_ = 1;
};

}  // namespace musher::vision
