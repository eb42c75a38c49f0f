#pragma once
// What distinguishes a painted sign and a lamp from leaves, petals and fur of their colour: how
// they end and what they look like all over. Pure.
//
// A thing of its own ends at a sharp edge all around, and nothing within it is as sharp. A sign is
// of one paint: its hue and its saturation are the same all over, in light and in a shadow. A lamp
// is alike in every direction: what is equally far from its middle looks the same.
//
// Units: levels of 255, and of OpenCV's hue. Threads: any.

#include <opencv2/core.hpp>
#include <optional>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

struct Surface {
  double edge_share = 0;  // of its outline that is a sharp edge
  double end_share = 0;   // of its outline that is sharper than all within
  // By so much nine tenths of it differ from its median colour, at most.
  double hue_spread = 0;
  double saturation_spread = 0;
  double saturation = 0;  // the median
  // By so much what is equally far from the middle differs, at most, its eight nearest tenths; as a
  // share of what the middle differs from what is around it.
  double ring_share = 0;
  bool is_darker_inside = false;  // in the middle than at its rim
};

// Of the thing with that convex outline. `bgr`: CV_8UC3.
Surface SurfaceOf(const cv::Mat& bgr, const Contour& outline);

// The round thing in the box as large as it is, where the box ends within it: what is as bright as
// its middle ends there, and the thing at a sharper edge around that. Nothing where such an edge is
// not equally far away all around.
std::optional<cv::Rect> UpToItsEdge(const cv::Mat& bgr, const cv::Rect& box);

// The outline of a round thing that fills the box.
Contour EllipseIn(const cv::Rect& box);

}  // namespace musher::vision
