#include <string>
#include <utility>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/modules/vision/course/marker_tracker.hpp"

namespace musher::vision {
namespace {

// Its next picture may not show it whole: a robot at 0.4 m/s comes nearer by a tenth of its size
// between two pictures, and some are missed. What leaves the picture farther away is not passed:
// the robot turns.
bool IsPassed(const cv::Rect& box, const cv::Size& picture, double distance_m, double within_m) {
  if (distance_m > within_m) return false;
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
    const double distance_m = DistanceBySizeM(lens, bgr.size(), found_ ? found_->size_px : 0,
                                              parameters_.size_m, parameters_.focal_px);
    const MarkerTracker::Phase phase = tracker_.OnPicture(
        found_.has_value(),
        found_ && IsPassed(found_->box, bgr.size(), distance_m, parameters_.passed_within_m));
    sight.sighting = NoSighting();
    word_ = PhaseText(phase);
    if (found_) {
      sight.sighting = SightingAt(found_->box, bgr.size());
      sight.sighting->distance_m = static_cast<float>(distance_m);
      sight.sighting->confidence = ConfidenceBy({found_->margin});
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
