#pragma once
// Square markers of a printed dictionary (ArUco, AprilTag) on boards: which word each stands for,
// and how far away it is. Pure.
//
// The marker with the number i stands for the word i of the list; others count as none. The largest
// counts. Where a second one is nearly as large and stands for another word, none does. The
// distance is that of the marker's middle, by its pose: of a marker that is turned away, too.
//
// Units: metres and pixels. Errors: as of color_mask.hpp.

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

enum class ArucoDictionary { k4x4, k5x5, k6x6, kAprilTag16h5, kAprilTag36h11 };

struct ArucoParameters {
  ArucoDictionary dictionary = ArucoDictionary::k4x4;  // each of 50 markers, tags of their family
  std::vector<std::string> words = {"A-1", "A-2", "B-1", "B-2"};  // of marker 0, 1, ...
  int min_repeats = 2;    // pictures in a row that have to agree
  double size_m = 0.15;   // the side of a marker's black square
  double focal_px = 600;  // of a picture 640 pixels wide, while no lens is known
  double nearly = 0.5;    // a marker that covers this share of the largest is nearly as large

  friend bool operator==(const ArucoParameters&, const ArucoParameters&) = default;
};

struct ArucoFound {
  std::string word;  // empty: of a marker without one, or of two that contradict each other
  int number = 0;
  cv::Rect box;
  double distance_m = 0;
  // Over the largest marker of another word: 0 where that is nearly as large, 1 without one.
  double margin = 0;
};

std::optional<ArucoFound> FindAruco(const cv::Mat& bgr, const ArucoParameters& parameters,
                                    const std::optional<Lens>& lens);

}  // namespace musher::vision
