#include "musher/modules/vision/faces/face_tracker.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

namespace musher::vision {
namespace {

// A face without overlap that is more than twice or less than half as large is another one.
constexpr double kMostSizeRatio = 2;

bool AboutAsLarge(const FaceBox& a, const FaceBox& b) {
  return a.height <= kMostSizeRatio * b.height && b.height <= kMostSizeRatio * a.height;
}

// How well a box continues a track; nothing: not at all.
using Fit = std::function<std::optional<double>(const Track&, const FaceBox&)>;

struct Pair {
  double fit = 0;
  std::size_t track = 0;
  std::size_t box = 0;
};

// The best pair first, each track and box once.
std::vector<Pair> Match(const std::vector<Track>& tracks, const std::vector<FaceBox>& boxes,
                        std::vector<bool>& taken_tracks, std::vector<bool>& taken_boxes,
                        const Fit& fit) {
  std::vector<Pair> pairs;
  for (std::size_t t = 0; t < taken_tracks.size(); ++t) {
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      if (taken_tracks[t] || taken_boxes[b]) continue;
      if (const auto value = fit(tracks[t], boxes[b])) pairs.push_back({*value, t, b});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.fit > b.fit; });
  std::vector<Pair> chosen;
  for (const Pair& pair : pairs) {
    if (taken_tracks[pair.track] || taken_boxes[pair.box]) continue;
    taken_tracks[pair.track] = true;
    taken_boxes[pair.box] = true;
    chosen.push_back(pair);
  }
  return chosen;
}

}  // namespace

void FaceTracker::OnPicture(std::int64_t stamp_ns, const std::vector<FaceBox>& boxes,
                            const std::set<int>& kept) {
  Forget(stamp_ns, Duration(stamp_ns - std::exchange(last_ns_, stamp_ns)), kept);
  for (Track& track : tracks_) track.seen = false;
  std::vector<FaceBox> faces;
  std::copy_if(boxes.begin(), boxes.end(), std::back_inserter(faces), [this](const FaceBox& box) {
    return IsFace(box) && box.width >= rules_.smallest && box.height >= rules_.smallest;
  });
  std::vector<bool> taken_tracks(tracks_.size());
  std::vector<bool> taken_boxes(faces.size());
  const auto take = [&](const Fit& fit) {
    for (const Pair& pair : Match(tracks_, faces, taken_tracks, taken_boxes, fit)) {
      See(tracks_[pair.track], faces[pair.box], stamp_ns);
    }
  };
  take([this](const Track& track, const FaceBox& box) -> std::optional<double> {
    const double iou = Iou(track.box, box);
    return iou >= rules_.iou ? std::optional(iou) : std::nullopt;
  });
  take([this](const Track& track, const FaceBox& box) -> std::optional<double> {
    const double distance = Distance(track.box, box);
    const bool same = distance <= rules_.distance && AboutAsLarge(track.box, box);
    return same ? std::optional(-distance) : std::nullopt;
  });
  for (std::size_t b = 0; b < faces.size(); ++b) {
    if (taken_boxes[b]) continue;
    Track& track = tracks_.emplace_back();
    track.id = next_id_++;
    See(track, faces[b], stamp_ns);
  }
}

void FaceTracker::Forget(std::int64_t stamp_ns, Duration gap, const std::set<int>& kept) {
  const Duration unconfirmed = std::max(rules_.confirm_within, 2 * gap);
  std::erase_if(tracks_, [&](const Track& track) {
    if (kept.contains(track.id)) return false;
    const Duration most = track.confirmed ? rules_.forget : unconfirmed;
    return Duration(stamp_ns - track.last_ns) > most;
  });
}

void FaceTracker::See(Track& track, const FaceBox& box, std::int64_t stamp_ns) const {
  const double passed_s = static_cast<double>(stamp_ns - track.last_ns) / 1e9;
  const double constant_s = ToSeconds(rules_.smoothing);
  const bool smooth = track.sightings > 0 && constant_s > 0;
  const double share = smooth ? 1 - std::exp(-passed_s / constant_s) : 1;
  track.height += (box.height - track.height) * share;
  track.box = box;
  track.last_ns = stamp_ns;
  track.seen = true;
  ++track.sightings;
  track.confirmed = track.confirmed || track.sightings >= rules_.confirm_pictures;
}

}  // namespace musher::vision
