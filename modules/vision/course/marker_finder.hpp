#pragma once
// A yellow sign, round or square, that hangs high over the lane; and a yellow ball of light in the
// way. Pure.
//
// A candidate is a yellow outline whose centre is in the region; what is attached to it and thinner
// than half of it, for example a line on the ground behind it, is cut off first. It has to be as
// wide as high, within limits, without dents, and as full as a circle or a square is; a light as a
// circle. The fullest of the largest counts. What the picture's edge cuts is none.
//
// A sign is clearly more saturated than what around it has its hue: white paper in warm light is
// not. Where much of the picture has the colour, as a wall in that light, what has an outline by
// its saturation alone counts, too.
//
// What has the colour of signs by chance is none: a sign is of one paint up to a sharp edge, and
// more saturated than white paper in warm light (thing_surface.hpp). A leaf, a petal or fur is not.
//
// A light has to shine as well (lamp_glow.hpp): it may be amber, and so bright that its middle is
// white in the picture. Where much of the picture has its colour, under warm lamps, it has a sharp
// edge and more green light than what is around it, or is clearly more saturated than the rest
// (floor_color.hpp). A light may be there or not, and that is a doubt, where a round thing that is
// only more saturated, or white from brightness, is nearer than any light that is found, or where
// much of the region is so bright that no lamp could be brighter. A light is alike in every
// direction and not darker in its middle: what shines, but not so, is none, and near to the robot a
// doubt. Its box reaches up to its edge, also where only its middle stands out from the rest.
//
// The region limits the centre only, so that what is near may be larger than the region. Circles
// are not searched in edges (Hough): the outline decides, which needs a tenth of the time and finds
// nothing in a noisy picture.
//
// Units: metres and pixels. Sizes and colours are those of a course: signs and lights of 0.2 m.

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "musher/modules/vision/course/color_mask.hpp"

namespace musher::vision {

struct MarkerParameters {
  HsvRange yellow{{15, 50, 50}, {35, 255, 255}};
  Region region{0, 0.45, 0, 1};  // of its centre
  double least_area_px2 = 200;
  double most_area_px2 = 15000;
  int kernel_px = 5;          // of opening and closing
  double least_aspect = 0.6;  // its shorter side, as a share of the longer one
  bool round_only = false;
  bool shines = false;           // a lamp: brighter than what is around it, maybe with a white core
  double size_m = 0.2;           // its diameter or its side
  double focal_px = 600;         // of a picture 640 pixels wide, while no lens is known
  int sightings = 2;             // in a row, before it is tracked
  int misses = 5;                // in a row, before it has disappeared
  double passed_within_m = 1.5;  // last seen farther away it has not disappeared, but is hidden

  friend bool operator==(const MarkerParameters&, const MarkerParameters&) = default;
};

// Those of a light: shining, from amber to yellow, a ball, in the middle of the picture. The
// region begins where a light 0.13 m above the camera is at 0.55 m, for a camera that is inclined 8
// degrees downwards: the race stops at 0.7 m. A sign at twice that height has left it at 0.9 m.
MarkerParameters LightParameters();

struct Marker {
  cv::Rect box;
  double size_px = 0;  // its diameter, or its longer side
  bool round = false;  // else square
  // Of its outline's shape: 0 at the limits, and of a lamp that is known by its glow; 1 for an
  // ideal circle or square.
  double margin = 0;
  Contour outline{};  // empty: an ellipse in the box
};

struct MarkerLook {
  std::optional<Marker> marker;
  std::string doubt;  // why a light cannot be distinguished from the rest; empty: it can
};
MarkerLook LookForMarker(const cv::Mat& bgr, const MarkerParameters& parameters);

// Without the doubt.
std::optional<Marker> FindMarker(const cv::Mat& bgr, const MarkerParameters& parameters);

}  // namespace musher::vision
