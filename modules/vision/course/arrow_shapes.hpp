#pragma once
// Arrows of usual shapes as silhouettes: blocks, chevrons, elbows (from below, then to a side) and
// arrows with a shaft that becomes wider. Pure.
//
// A silhouette is scaled to a small square, and compared with those of arrows to the left and to
// the right and of what is none: arrows upwards, downwards and both ways, squares, discs, crosses.
//
// Threads: any.

#include <opencv2/core.hpp>
#include <optional>

namespace musher::vision {

// How badly the best silhouette of each sort fits: 0 fits, 1 has nothing in common.
struct ShapeMisfits {
  double left = 1;
  double right = 1;
  double other = 1;
};

// `silhouette`: CV_8UC1, 0 where it is not; anything around it is ignored. Nothing without a pixel.
std::optional<ShapeMisfits> CompareShapes(const cv::Mat& silhouette);

}  // namespace musher::vision
