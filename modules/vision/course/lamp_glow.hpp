#pragma once
// What distinguishes a lamp from a yellow thing: it shines. Pure.
//
// A lamp is a round area that is clearly brighter than what is around it, or brighter in its middle
// than at its rim, or so bright that its middle is white in the picture: then the colour of the
// lamp is in a ring around that core, more saturated than the rest. Before a bright wall it has all
// the red and green that a picture can have, which paint has not. A yellow disc on a poster is as
// bright as its rim and hardly brighter than the poster.
//
// Units: pixels, OpenCV's hue, saturation and value. Threads: any.

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

// Whether the round thing in that box shines, which has the colour of lamps. `hsv`: CV_8UC3.
bool Shines(const cv::Mat& hsv, const cv::Rect& box);

// Round areas that are bright and nearly white, with a ring of the lamps' colour around each, which
// belongs to the box.
std::vector<cv::Rect> FindWhiteCores(const cv::Mat& hsv, const HsvRange& color);

// Where much of a picture has the lamps' colour, because the hall's light has it.
struct LampsInWarmLight {
  // Round things with a sharp edge that have the colour and more green light than what is around
  // them, and are more saturated, or have all the green that a picture can have.
  std::vector<cv::Rect> shining;
  // Those that are only more saturated, or only have more green, or are white from brightness:
  // paint, paper, or a lamp.
  std::vector<cv::Rect> round;
  double too_bright = 0;  // share of the searched region before which no lamp would be seen
};
LampsInWarmLight FindLampsInWarmLight(const cv::Mat& bgr, const HsvRange& color,
                                      const Region& searched);

}  // namespace musher::vision
