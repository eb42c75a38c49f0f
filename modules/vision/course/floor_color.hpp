#pragma once
// Yellow lines on a floor that may have their colour: oak, or any floor under warm lamps. Pure.
//
// Lines cover a small part of the floor. Where more than `most_coverage` of a region is in the
// range of their colour, or where it is found all over a sample of the floor, the floor is; then
// lines are what is clearly more saturated than the rest of it, and of one saturation, because
// paint and tape are. Where nothing is, the lines cannot be distinguished from the floor.

#include <opencv2/core.hpp>
#include <string>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

struct LineMask {
  cv::Mat mask;       // CV_8UC1: 255 on lines; of a doubt all 0
  std::string doubt;  // why the lines cannot be distinguished from the floor; empty: they can
};

// `bgr`: the region. `most_coverage`: a share of it. `floor`: a sample of the floor, in which lines
// may be; empty: the region alone counts.
LineMask MaskOfLines(const cv::Mat& bgr, const HsvRange& yellow, double most_coverage,
                     const cv::Mat& floor = {});

}  // namespace musher::vision
