#pragma once
// A bar of stripes, red and white or yellow and black: pieces of one colour in a level row, of one
// height, with gaps of the other colour between them. Pure.
//
// What else stands in rows is not taken for it: bricks have narrow joints and more rows above and
// below them, pieces of a line on the ground are longer than stripes are, and slats narrower.
// Between lamps, chairs or pennants in a row the scene behind them is seen, which goes on above or
// below.
//
// Units: pixels, degrees from level. Threads: any.

#include <opencv2/core.hpp>
#include <vector>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

struct StripedBar {
  cv::Rect box;
  double length_px = 0;
  double height_px = 0;
  double tilt_deg = 0;
};

enum class Gaps { kLight, kDark };

// `hsv`: CV_8UC3; `mask`: where it has the colour of the pieces.
std::vector<StripedBar> FindStripedBars(const cv::Mat& hsv, const cv::Mat& mask, Gaps gaps);

// The share of the mask along a line that is parallel to the bar's axis, `aside_px` below it,
// without the outer tenths; nothing outside of the picture counts.
double ShareAlong(const cv::Mat& mask, const cv::Point2d& from, const cv::Point2d& to,
                  double aside_px);

}  // namespace musher::vision
