#include "musher/modules/vision/faces/face_watch.hpp"

namespace musher::vision {

Sight FaceWatch::OnPicture(std::int64_t stamp_ns, const std::vector<FaceBox>& boxes,
                           const std::optional<Lens>& lens) {
  Sight sight;
  sight.stamp_ns = stamp_ns;
  tracker_.OnPicture(stamp_ns, boxes, near_.TooNear());
  std::vector<TargetChoice::Candidate> frontal;
  std::vector<Closeness::Sighting> distances;
  for (const Track& track : tracker_.tracks()) {
    if (!track.seen || !track.confirmed) continue;
    Sight::Face face{track.id, track.box, std::nullopt};
    if (lens) {
      face.distance_m = DistanceM(*lens, track.box, track.height, rules_.face_m);
      distances.push_back({track.id, *face.distance_m});
    }
    if (track.box.frontal) frontal.push_back({track.id, track.height});
    sight.faces.push_back(face);
  }
  const std::optional<int> target = target_.OnPicture(stamp_ns, frontal);
  for (const Sight::Face& face : sight.faces) {
    if (face.id == target) sight.target = face;
  }
  if (lens) near_.OnPicture(stamp_ns, distances);
  if (lens && near_.known()) sight.too_close = near_.too_close();
  return sight;
}

}  // namespace musher::vision
