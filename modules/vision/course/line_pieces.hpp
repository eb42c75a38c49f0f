#pragma once
// The outlines of a mask as lines on the floor: pieces of one line are joined, and what is not as
// wide as a line, or does not stand out from the floor around it, is left out. Pure.
//
// The floor is the ground in metres where the camera's mount is known, else the picture in pixels.
// A piece belongs to a longer one when it lies on its axis and not far from its end: a shadow, a
// foot or glare lies between. The opening of a lane in a line that it crosses is farther. x is to
// the right, y downwards, both in the region.
//
// Threads: any. Errors: as of color_mask.hpp.

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/vision/course/color_mask.hpp"
#include "musher/navigation/camera/mounted_camera.hpp"

namespace musher::vision {

// Where a camera is on the body. Its region of interest is not part of it.
struct Mount {
  navigation::MountedCamera camera;
  double trunk_height_m = 0.29;  // of the trunk's middle above the ground

  friend bool operator==(const Mount&, const Mount&) = default;
};

// What a camera sees in a region: pixels of the region to places on the floor, and back. Places are
// in the frame of mounted_camera.hpp with a mount, else they are the pixels themselves.
class Floor {
 public:
  static constexpr double kFarthestM = 4;  // points beyond have no place

  Floor(const std::optional<Mount>& mount, const cv::Rect& region, const cv::Size& picture)
      : mount_(mount), region_(region), picture_(picture) {}

  bool in_metres() const { return mount_.has_value(); }
  // Of a point of the region, in pixels of it. Nothing above the horizon, and beyond kFarthestM.
  std::optional<cv::Point2d> At(double x, double y) const;
  // The inverse, also beside the region; nothing for what the picture does not show.
  std::optional<cv::Point2d> Seen(const cv::Point2d& on_floor) const;
  // How much of a way on the ground is across the camera's view; 0 without a mount.
  double Across(const cv::Point2d& way) const;
  // Whether a direction on the ground leads away from the camera rather than across its view; false
  // without a mount.
  bool LeadsAway(const cv::Point2d& direction) const;

 private:
  std::optional<Mount> mount_;
  cv::Rect region_;
  cv::Size picture_;
};

// A line, of one piece or several.
struct YellowLine {
  std::vector<Contour> pieces;
  double area_px2 = 0;
  cv::Point2d centroid;
  // Of a line on the ground that leads away from the camera, where its axis crosses the middle row
  // of the region, so that a half of it that is hidden does not shift it; of others the centroid.
  cv::Point2d place;
  bool leads_away = false;   // it is such a line
  bool lies_across = false;  // it leads aside; not of the end of a piece that the region cuts off
  cv::Rect box;
  // On the floor.
  cv::Point2d middle;
  cv::Point2d axis;     // of length 1
  double length = 0;    // along the axis,
  double width = 0;     // and across it
  bool placed = false;  // these four are known

  // It is long enough for its axis to mean something.
  bool has_axis() const { return placed && length >= 2 * width; }
};

// Between two lines: across the longer one, or where neither has an axis across the camera's view.
// Nothing where it is not known.
std::optional<double> Gap(const YellowLine& one, const YellowLine& other, const Floor& floor);

struct PieceRules {
  HsvRange color;
  double least_area_px2 = 0;
  double least_length = 0;  // of its box: times as wide as high
  // Of a line on the ground, in metres; only where a mount is known.
  double least_width_m = 0;
  double most_width_m = 1;
};

struct LinesOnFloor {
  std::vector<YellowLine> lines;  // the largest first
  std::string odd;          // why the largest outline that is none was left out; empty: none was
  double odd_area_px2 = 0;  // of all that were left out
};

// `bgr`: the region, as large as its mask.
LinesOnFloor LinesOf(const cv::Mat& bgr, const cv::Mat& mask, const Floor& floor,
                     const PieceRules& rules);

}  // namespace musher::vision
