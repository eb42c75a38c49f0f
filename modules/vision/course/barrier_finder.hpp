#pragma once
// A red bar across the lane, under which the robot passes: where it is and how far. Pure.
//
// A bar is red, much longer than high, and fills the rectangle around it; the largest one counts.
// The bar of a gate counts without its posts. A striped one is red and white, or yellow and black
// (bar_stripes.hpp). Its height in the picture, the mean one, gives the distance. It counts as
// "top" when its upper edge is in the uppermost part of the picture: the robot is about to pass
// beneath.
//
// A bar stands alone and is of one colour: a wall of bricks and the stripes of a flag are none.
// What the upper or the lower edge of the picture cuts may be anything red, for example a shirt; it
// counts where it is at least half as wide as the picture and not a quarter as high, as a bar is
// that is so near. Where red is the colour of much of the picture, under warm lamps, only what is
// clearly more saturated counts.
//
// Simpler than the rules that are usual on this course: one range of reds instead of four joined
// masks, the whole picture instead of four bands with a score each. The length, the fill and the
// least area refuse what the scores refused.
//
// Units: metres and pixels. 0.2 m and a focal length of 600 px are the usual estimate of 60 px at
// 2 m. A bar that the picture's upper or lower edge cuts has no distance.

#include <opencv2/core.hpp>
#include <optional>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

struct BarrierParameters {
  HsvRange red{{170, 50, 50}, {10, 255, 255}};
  Region region;
  double least_area_px2 = 100;
  double least_length = 4;    // of the bar, in its heights
  double least_fill = 0.6;    // of the rectangle around it
  double most_tilt_deg = 25;  // from level
  double top = 0.1;           // of the picture's height
  double height_m = 0.2;      // of the bar
  double focal_px = 600;      // of a picture 640 pixels wide, while no lens is known
  bool striped = true;        // bars of stripes count, too: red and white, yellow and black
  HsvRange yellow{{12, 120, 60}, {35, 255, 255}};  // of their stripes

  friend bool operator==(const BarrierParameters&, const BarrierParameters&) = default;
};

struct Barrier {
  cv::Rect box;
  double height_px = 0;  // the mean one
  bool top = false;
  bool cut = false;  // by the upper or the lower edge of the picture
  // Of its length, fill and tilt: 0 at the limits and for a bar that is cut, 1 for an ideal one.
  double margin = 0;
};

std::optional<Barrier> FindBarrier(const cv::Mat& bgr, const BarrierParameters& parameters);

}  // namespace musher::vision
