#include <string>
#include <utility>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/modules/vision/course/marker_tracker.hpp"

namespace musher::vision {
namespace {

// Its next picture may not show it whole: a robot at 0.4 m/s comes nearer by a tenth of its size
// between two pictures, and some are missed.
bool IsAtEdge(const cv::Rect& box, const cv::Size& picture) {
  constexpr double kSizes = 0.6;
  const double x = kSizes * box.width, y = kSizes * box.height;
  return box.x < x || box.y < y || box.br().x > picture.width - x ||
         box.br().y > picture.height - y;
}

class MarkerDetector : public CourseDetector {
 public:
  explicit MarkerDetector(const MarkerParameters& parameters)
      : parameters_(parameters), tracker_(parameters.sightings, parameters.misses) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t /*stamp_ns*/,
                   const std::optional<Lens>& lens) override {
    MarkerLook look = LookForMarker(bgr, parameters_);
    found_ = look.marker;
    CourseSight sight;
    if (!look.doubt.empty()) {  // neither a picture with it nor one without it
      sight.doubt = std::move(look.doubt);
      word_ = "?";
      return sight;
    }
    const MarkerTracker::Phase phase =
        tracker_.OnPicture(found_.has_value(), found_ && IsAtEdge(found_->box, bgr.size()));
    sight.sighting = NoSighting();
    word_ = PhaseText(phase);
    if (found_) {
      const double distance_m = DistanceBySizeM(lens, bgr.size(), found_->size_px,
                                                parameters_.size_m, parameters_.focal_px);
      sight.sighting = SightingAt(found_->box, bgr.size());
      sight.sighting->distance_m = static_cast<float>(distance_m);
      const auto metres = MetresText(distance_m);
      if (phase == MarkerTracker::Phase::kTracking) sight.text = metres;
      word_ += metres ? " " + *metres + " m" : "";
    }
    sight.sighting->phase = PhaseText(phase);
    return sight;
  }

  void Draw(cv::Mat& bgr) const override {
    DrawRegion(bgr, parameters_.region);
    if (found_) {
      DrawBox(bgr, found_->box, word_);
    } else {
      DrawWord(bgr, RectOf(parameters_.region, bgr.size()).tl(), word_);
    }
  }

 private:
  const MarkerParameters parameters_;
  MarkerTracker tracker_;
  std::optional<Marker> found_;
  std::string word_;
};

}  // namespace

std::unique_ptr<CourseDetector> MakeMarkerDetector(const MarkerParameters& parameters) {
  return std::make_unique<MarkerDetector>(parameters);
}

}  // namespace musher::vision
