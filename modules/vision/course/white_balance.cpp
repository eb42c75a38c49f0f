#include "musher/modules/vision/course/white_balance.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {
namespace {

class BalancedDetector : public CourseDetector {
 public:
  BalancedDetector(std::unique_ptr<CourseDetector> detector, const WhiteBalance& balance)
      : detector_(std::move(detector)), balance_(balance) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t stamp_ns,
                   const std::optional<Lens>& lens) override {
    return detector_->Look(Balanced(bgr, balance_), stamp_ns, lens);
  }

  void Draw(cv::Mat& bgr) const override { detector_->Draw(bgr); }

 private:
  const std::unique_ptr<CourseDetector> detector_;
  const WhiteBalance balance_;
};

}  // namespace

cv::Mat Balanced(const cv::Mat& bgr, const WhiteBalance& balance) {
  CheckCoursePicture(bgr);
  constexpr int kValues = 256;
  const std::array gains{balance.blue, balance.green, balance.red};
  cv::Mat table(1, kValues, CV_8UC3);
  for (int i = 0; i < kValues; ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      table.at<cv::Vec3b>(i)[channel] =
          cv::saturate_cast<std::uint8_t>(std::lround(i * gains.at(std::size_t(channel))));
    }
  }
  cv::Mat balanced;
  cv::LUT(bgr, table, balanced);
  // At the limit of the camera a colour is not known: what is white there stays white.
  constexpr int kLimit = 250;
  cv::Mat clipped;
  cv::inRange(bgr, cv::Scalar::all(kLimit), cv::Scalar::all(kValues - 1), clipped);
  balanced.setTo(cv::Scalar::all(kValues - 1), clipped);
  return balanced;
}

std::unique_ptr<CourseDetector> WithBalance(std::unique_ptr<CourseDetector> detector,
                                            const WhiteBalance& balance) {
  return std::make_unique<BalancedDetector>(std::move(detector), balance);
}

}  // namespace musher::vision
