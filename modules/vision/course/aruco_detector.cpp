#include <utility>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/modules/vision/course/words.hpp"

namespace musher::vision {
namespace {

class ArucoDetector : public CourseDetector {
 public:
  explicit ArucoDetector(ArucoParameters parameters)
      : parameters_(std::move(parameters)), words_(parameters_.min_repeats) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t /*stamp_ns*/,
                   const std::optional<Lens>& lens) override {
    found_ = FindAruco(bgr, parameters_, lens);
    CourseSight sight;
    sight.sighting = NoSighting();
    const bool has_word = found_ && !found_->word.empty();
    sight.text = words_.OnPicture(has_word ? std::optional(found_->word) : std::nullopt);
    if (!found_) return sight;
    sight.sighting = SightingAt(found_->box, bgr.size());
    sight.sighting->distance_m = static_cast<float>(found_->distance_m);
    if (!sight.text) return sight;
    sight.sighting->text = *sight.text;
    sight.sighting->confidence = ConfidenceBy({found_->margin});
    return sight;
  }

  void Draw(cv::Mat& bgr) const override {
    if (!found_) return;
    const std::string word = found_->word.empty() ? "?" : found_->word;
    DrawBox(bgr, found_->box, word + " (" + std::to_string(found_->number) + ")");
  }

 private:
  const ArucoParameters parameters_;
  WordRepeats words_;
  std::optional<ArucoFound> found_;
};

}  // namespace

std::unique_ptr<CourseDetector> MakeArucoDetector(const ArucoParameters& parameters) {
  return std::make_unique<ArucoDetector>(parameters);
}

}  // namespace musher::vision
