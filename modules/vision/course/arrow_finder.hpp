#pragma once
// A green arrow on a board, or a white one on a green board: whether it points to the left or to
// the right. Pure.
//
// The height of the green along the arrow's axis is compared with that of an arrow: a shaft of one
// height, then a head that narrows to a point. Both directions are tried with heads and shafts of
// many proportions; the better fit is the direction, when it is good and clearly better. An axis
// that is tilted up to 30 degrees is followed. What does not fit is compared with chevrons, elbows
// and arrows that become wider (arrow_shapes.hpp), and what only they fit is a direction, when
// shapes that are no such arrow fit clearly worse. The green must be surrounded by something that
// is not green: grass and trees are none.
//
// The usual votes (centroid beside the middle of the box by a tenth of its width, and the end that
// is nearer to half the height) are not used: the centroid of an ordinary arrow is nearer to the
// middle than that, and the second vote depends on which pixel of the shaft's blunt end is the
// outermost. The position in the picture decided then, which says nothing of the direction.
//
// Units: pixels. The colour and the least area are those of a course with boards of 0.3 m and more,
// read from 0.5 to 3 m.

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

struct ArrowParameters {
  HsvRange green{{35, 50, 50}, {85, 255, 255}};
  Region region;
  double least_area_px2 = 1000;
  int kernel_px = 5;                // of opening and closing
  double most_misfit = 0.12;        // mean difference of the heights, as a share of the arrow's own
  double clearly = 1.5;             // factor by which the other direction has to fit worse
  bool other_shapes = true;         // chevrons, elbows and white arrows on green, too
  double most_shape_misfit = 0.25;  // share of the area that only one of the two shapes covers

  friend bool operator==(const ArrowParameters&, const ArrowParameters&) = default;
};

struct Arrow {
  cv::Rect box;
  bool left = false;  // else right
  double misfit = 0;
  double margin =
      0;  // of the fit, and over the other direction: 0 at the limits, 1 for an ideal one
};

struct ArrowsFound {
  std::vector<Arrow> arrows;  // the largest first
  // "left" or "right"; empty without an arrow, and when arrows disagree.
  std::string direction;
};

ArrowsFound FindArrows(const cv::Mat& bgr, const ArrowParameters& parameters);

}  // namespace musher::vision
