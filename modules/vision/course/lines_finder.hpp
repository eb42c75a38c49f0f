#pragma once
// Yellow lines on the ground: where the robot is between two of them, and how far one is. Pure.
//
// A line is an outline of the mask of yellow pixels in the region, not smaller than the least area,
// and of the least length for its height; at most `most_lines` count, the largest ones. Pieces of
// one line are one (line_pieces.hpp), and a floor of the same colour is none (floor_color.hpp). x
// is to the right, y downwards, both in the region.
//
//   ycy   The middle between the leftmost and the rightmost centroid (see LanePair) is left of the
//         centre by more than the threshold: "right", for the robot is right of the middle; and
//         vice versa. The centre is that of the region, or for a camera that is not in the middle
//         of the body beside it (`ycy_center`). Otherwise "center".
//         Two lines nearer to each other than a lane are one line; of two that are farther apart
//         the nearer one counts alone. With `along` a line that lies across the camera's view is
//         none; a doubt are a single line, two that are not a lane apart, and only lines across.
//         Else the middle of one line is half a lane beside it, towards the centre.
//         Without the camera's mount only the line's side is known: the
//         robot is too near to it, so that a line on the left is "left".
//   dy    The line whose centroid is nearest to the vertical centre line: farther away than the
//         target by more than the threshold (higher in the picture) is "front", nearer "back".
//   walk  Of the same line: its lower edge is nearer to the bottom of the picture than the limit,
//         "back"; else its centroid is farther from the centre line than the limit, "front".
//
// How well the middle is known, in metres across the lane, is said where the mount is and the lines
// lead away from the camera: by the pixels and the blur of the camera, the width of each line, how
// far a line is continued to where it counts, and by how much the distance of two lines differs
// from a lane's width; of one line by how well that width is known. Where left or right is nearer
// to the middle than that, it is a doubt.
//
// With no line at all the words are "center", and `contours` is 0. With a doubt the words are
// "center", too, and `doubt` says why they mean nothing: the floor has the colour of the lines;
// what has it, or most of it, is not as wide as a line, does not stand out from the floor, or has
// not the shape of a line; the only line may be another lane's.
//
// Distance for a given offset: on a lane 0.83 m wide, `middle_offset` changes by 0.05 for
// each 0.1 m beside its middle in the picture of the front camera, and by 0.036 in that of a
// fisheye, for the region below. The threshold of 0.08 is 0.19 m and 0.20 m.
//
// Units: pixels, and fractions where the name of a field has no unit. The numbers are those of a
// course with lanes 0.83 m wide; a threshold for dy of 0.81, found beside them, can never be
// exceeded.

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/modules/vision/course/color_mask.hpp"
#include "musher/modules/vision/course/line_pieces.hpp"

namespace musher::vision {

// Which two lines are those of the lane, where there are more than two.
enum class LanePair : std::uint8_t {
  kOutermost,  // the leftmost and the rightmost
  kInnermost,  // the nearest to the centre on either side; where a side has none, the outermost
};

struct LinesParameters {
  HsvRange yellow{{15, 50, 30}, {35, 255, 255}};
  Region region{0.6, 1, 0, 1};
  double least_area_px2 = 300;
  double least_length = 0;  // times as wide as high, so that only lines across count; 0: all do
  int most_lines = 5;
  // Only lines that lead away from the camera count, and two of them as far apart as those of a
  // lane, along which it looks; needs the camera's mount.
  bool along = false;
  double ycy_threshold = 0.08;  // of the region's width
  LanePair ycy_pair = LanePair::kOutermost;
  double ycy_center = 0.5;     // of the region's width: where the middle of the lines has to be
  double dy_threshold = 0.15;  // of the region's height
  double dy_target = 0.5;      // of the region's height, from its top
  double walk_bottom_px = 50;
  double walk_x_px = 30;
  int edge_columns = 24;         // in which the edge towards the robot is reported
  double most_coverage = 0.4;    // share of the region that lines cover; more is the floor
  std::optional<Mount> mount{};  // of the camera; what follows needs it
  double lane_m = 0.88;          // between the middles of a lane's two lines
  double least_width_m = 0.02;   // of a line
  double most_width_m = 0.1;

  friend bool operator==(const LinesParameters&, const LinesParameters&) = default;
};

struct LinesFound {
  msg::YellowLines lines;         // without a header
  std::vector<Contour> outlines;  // in the picture, the largest first
};

LinesFound FindLines(const cv::Mat& bgr, const LinesParameters& parameters);

}  // namespace musher::vision
