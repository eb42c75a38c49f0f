#include <limits>
#include <utility>

#include "musher/modules/vision/course/course_detectors.hpp"

namespace musher::vision {
namespace {

class BarrierDetector : public CourseDetector {
 public:
  explicit BarrierDetector(const BarrierParameters& parameters) : parameters_(parameters) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t /*stamp_ns*/,
                   const std::optional<Lens>& lens) override {
    const bool was_seen = std::exchange(found_, FindBarrier(bgr, parameters_)).has_value();
    CourseSight sight;
    if (!found_) {
      sight.sighting = NoSighting();
      return sight;
    }
    const double distance_m = found_->cut
                                  ? std::numeric_limits<double>::quiet_NaN()
                                  : DistanceBySizeM(lens, bgr.size(), found_->height_px,
                                                    parameters_.height_m, parameters_.focal_px);
    sight.sighting = SightingAt(found_->box, bgr.size());
    // The bar that the robot comes to is seen before; by what one picture shows it does not stoop.
    sight.sighting->phase = found_->top && was_seen ? "top" : "seen";
    sight.sighting->distance_m = static_cast<float>(distance_m);
    sight.sighting->confidence = ConfidenceBy({found_->margin});
    sight.text = MetresText(distance_m);
    word_ = sight.sighting->phase + (sight.text ? " " + *sight.text + " m" : "");
    return sight;
  }

  void Draw(cv::Mat& bgr) const override {
    DrawRegion(bgr, parameters_.region);
    if (found_) DrawBox(bgr, found_->box, word_);
  }

 private:
  const BarrierParameters parameters_;
  std::optional<Barrier> found_;
  std::string word_;
};

}  // namespace

std::unique_ptr<CourseDetector> MakeBarrierDetector(const BarrierParameters& parameters) {
  return std::make_unique<BarrierDetector>(parameters);
}

}  // namespace musher::vision
