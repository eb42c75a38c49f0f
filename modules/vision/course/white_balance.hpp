#pragma once
// The white balance of a hall: what a camera without one of its own records under warm or cold
// lamps, as in daylight. Pure.
//
// Threads: any. Errors: as of color_mask.hpp.

#include <memory>
#include <opencv2/core.hpp>

#include "musher/modules/vision/course/course_detector.hpp"

namespace musher::vision {

// Factors of a picture's values; 1 changes nothing.
struct WhiteBalance {
  double red = 1;
  double green = 1;
  double blue = 1;

  friend bool operator==(const WhiteBalance&, const WhiteBalance&) = default;
};

inline constexpr double kLeastGain = 0.2, kMostGain = 5;

// The picture with it; values beyond 255 are 255. Pixels with all values at the limit of the
// camera, 250 and above, are white, whatever the factors are.
cv::Mat Balanced(const cv::Mat& bgr, const WhiteBalance& balance);

// A detector that looks at balanced pictures. It draws on the picture as it is.
std::unique_ptr<CourseDetector> WithBalance(std::unique_ptr<CourseDetector> detector,
                                            const WhiteBalance& balance);

}  // namespace musher::vision
