// Every detector of a course with pictures of odd sizes and contents: it finds something or
// nothing, and throws nothing. A detector that throws five times in a row is given up.

#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/test/modules/vision/course_pictures.hpp"

namespace musher::vision::odd_pictures_test {

using Maker = std::function<std::unique_ptr<CourseDetector>()>;

std::vector<std::pair<std::string, Maker>> Detectors() {
  return {{"qr", [] { return MakeQrDetector({}); }},
          {"arrow", [] { return MakeArrowDetector({}); }},
          {"barrier", [] { return MakeBarrierDetector({}); }},
          {"marker", [] { return MakeMarkerDetector({}); }},
          {"light", [] { return MakeMarkerDetector(LightParameters()); }},
          {"lines", [] { return MakeLinesDetector({}); }}};
}

const std::vector<cv::Size> kSizes = {{1, 1},  {1, 480}, {640, 1},  {2, 2},    {3, 7},
                                      {17, 5}, {5, 300}, {8192, 2}, {2, 8192}, {31, 31}};

std::vector<cv::Mat> PicturesOf(const cv::Size& size) {
  std::vector<cv::Mat> pictures;
  for (const cv::Scalar& color : {kGrey, kYellow, kRed, kGreen, kWhite, cv::Scalar()}) {
    pictures.emplace_back(size, CV_8UC3, color);
  }
  pictures.emplace_back();
  cv::resize(NoisePicture(7), pictures.back(), size, 0, 0, cv::INTER_NEAREST);
  return pictures;
}

TEST(OddPictures, OfEverySizeAreLookedAtWithoutAnException) {
  for (const auto& [name, make] : Detectors()) {
    const std::unique_ptr<CourseDetector> detector = make();
    std::int64_t stamp_ns = 0;
    for (const cv::Size& size : kSizes) {
      for (const cv::Mat& picture : PicturesOf(size)) {
        stamp_ns += 100'000'000;
        cv::Mat bgr = picture.clone();
        EXPECT_NO_THROW({
          detector->Look(bgr, stamp_ns, std::nullopt);
          detector->Draw(bgr);
        }) << name
           << " " << size.width << " x " << size.height;
      }
    }
  }
}

// Two arrows of one size that disagree: neither is taken.
TEST(OddPictures, OfTwoArrowsThatDisagreeHaveNoDirection) {
  cv::Mat bgr = GreyPicture();
  DrawArrow(bgr, {60, 120, 200, 120});
  cv::Mat other = GreyPicture();
  DrawArrow(other, {60, 120, 200, 120});
  cv::Mat(Mirrored(other), cv::Rect(320, 0, 320, 480)).copyTo(bgr(cv::Rect(320, 0, 320, 480)));
  const auto detector = MakeArrowDetector({});
  const CourseSight sight = detector->Look(bgr, 1, std::nullopt);
  ASSERT_TRUE(sight.sighting);
  EXPECT_TRUE(sight.sighting->seen);
  EXPECT_EQ(sight.sighting->text, "");
  EXPECT_FALSE(sight.text);
}

}  // namespace musher::vision::odd_pictures_test
