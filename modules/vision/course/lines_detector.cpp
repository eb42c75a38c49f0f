#include <opencv2/imgproc.hpp>
#include <utility>

#include "musher/modules/vision/course/course_detectors.hpp"

namespace musher::vision {
namespace {

class LinesDetector : public CourseDetector {
 public:
  explicit LinesDetector(const LinesParameters& parameters) : parameters_(parameters) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t /*stamp_ns*/,
                   const std::optional<Lens>& /*lens*/) override {
    found_ = FindLines(bgr, parameters_);
    CourseSight sight;
    sight.lines = found_.lines;
    return sight;
  }

  void Draw(cv::Mat& bgr) const override {
    DrawRegion(bgr, parameters_.region);
    const msg::YellowLines& lines = found_.lines;
    cv::drawContours(bgr, found_.outlines, -1, cv::Scalar(255, 0, 255), 1);
    for (std::size_t i = 0; i < lines.edge_x.size(); ++i) {
      const cv::Point point(static_cast<int>(lines.edge_x[i] * float(bgr.cols)),
                            static_cast<int>(lines.edge_y[i] * float(bgr.rows)));
      cv::circle(bgr, point, 3, cv::Scalar(0, 0, 255), cv::FILLED);
    }
    const cv::Rect region = RectOf(parameters_.region, bgr.size());
    const std::string words =
        !lines.doubt.empty()  ? "?"
        : lines.contours == 0 ? "no line"
                              : "ycy " + lines.ycy + ", dy " + lines.dy + ", walk " + lines.walk;
    DrawWord(bgr, region.tl(), words);
  }

 private:
  const LinesParameters parameters_;
  LinesFound found_;
};

}  // namespace

std::unique_ptr<CourseDetector> MakeLinesDetector(const LinesParameters& parameters) {
  return std::make_unique<LinesDetector>(parameters);
}

}  // namespace musher::vision
