#include "musher/modules/vision/course/course_detectors.hpp"

namespace musher::vision {
namespace {

class ArrowDetector : public CourseDetector {
 public:
  explicit ArrowDetector(const ArrowParameters& parameters) : parameters_(parameters) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t /*stamp_ns*/,
                   const std::optional<Lens>& /*lens*/) override {
    found_ = FindArrows(bgr, parameters_);
    CourseSight sight;
    if (found_.arrows.empty()) {
      sight.sighting = NoSighting();
      return sight;
    }
    sight.sighting = SightingAt(found_.arrows.front().box, bgr.size());
    sight.sighting->text = found_.direction;
    if (!found_.direction.empty()) {
      sight.sighting->confidence = ConfidenceBy({found_.arrows.front().margin});
    }
    if (!found_.direction.empty() && found_.direction != last_) {
      last_ = found_.direction;
      sight.text = last_;
    }
    return sight;
  }

  void Draw(cv::Mat& bgr) const override {
    DrawRegion(bgr, parameters_.region);
    for (const Arrow& arrow : found_.arrows) DrawBox(bgr, arrow.box, arrow.left ? "left" : "right");
  }

 private:
  const ArrowParameters parameters_;
  ArrowsFound found_;
  std::string last_;  // the direction that was published
};

}  // namespace

std::unique_ptr<CourseDetector> MakeArrowDetector(const ArrowParameters& parameters) {
  return std::make_unique<ArrowDetector>(parameters);
}

}  // namespace musher::vision
