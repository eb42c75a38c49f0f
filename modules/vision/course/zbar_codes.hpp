#pragma once
// The codes that ZBar reads: also some with a glare over squares that ZXing does not.
// Pure.
//
// Threads: any.

#include <opencv2/core.hpp>
#include <vector>

#include "musher/modules/vision/course/qr_finder.hpp"

namespace musher::vision {

// Of a picture of CV_8UC1.
std::vector<CodeFound> CodesOfZBar(const cv::Mat& grey);

}  // namespace musher::vision
