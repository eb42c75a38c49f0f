#pragma once
// What the finders of a course have in common: a part of the picture, a range of colours, the mask
// of the pixels in it, and a distance by a known size. Pure.
//
// Threads: any. Errors: a picture that is empty or not CV_8UC3 ends the process (MUSHER_CHECK).

#include <array>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/modules/vision/picture/lens.hpp"

namespace musher::vision {

using Contour = std::vector<cv::Point>;

// A part of the picture, in fractions of its height and width from the upper left corner.
struct Region {
  double top = 0;
  double bottom = 1;
  double left = 0;
  double right = 1;

  friend bool operator==(const Region&, const Region&) = default;
};

// In pixels, within the picture and at least one pixel large.
cv::Rect RectOf(const Region& region, const cv::Size& picture);

// Hue, saturation and value in OpenCV's scale: 0 to 179, 0 to 255, 0 to 255. Both ends belong to
// it. A hue from 170 to 10 goes through 0: red.
struct HsvRange {
  std::array<int, 3> from{0, 0, 0};
  std::array<int, 3> to{179, 255, 255};

  friend bool operator==(const HsvRange&, const HsvRange&) = default;
};

// 255 where the colour is in the range, else 0.
cv::Mat MaskOf(const cv::Mat& bgr, const HsvRange& range);
cv::Mat MaskOfHsv(const cv::Mat& hsv, const HsvRange& range);  // of converted pixels

bool IsIn(const cv::Vec3b& hsv, const HsvRange& range);

// Removes spots smaller than `open_px`, then closes gaps smaller than `close_px`. Up to 1: not.
void CleanMask(cv::Mat& mask, int open_px, int close_px);

// Of the outer outlines; areas are those that an outline encloses.
std::vector<Contour> OutlinesOf(const cv::Mat& mask);

// To a thing of that size ahead that is `size_px` large in the picture. Without a lens, with a
// focal length of `focal_px` in a picture that is 640 pixels wide.
double DistanceBySizeM(const std::optional<Lens>& lens, const cv::Size& picture, double size_px,
                       double size_m, double focal_px);

// The confidence in a thing that its detector's rules accept: 0.5 where one of them is just met, up
// to 1 where all are met ideally. A margin is 0 at the limit of a rule, and 1 for the ideal thing.
float ConfidenceBy(std::initializer_list<double> margins);

// A sighting with that box, of the least confidence, and all else unknown.
msg::Sighting SightingAt(const cv::Rect& box, const cv::Size& picture);

// A sighting of nothing.
msg::Sighting NoSighting();

// "1.24"; nothing for a distance that is not known.
std::optional<std::string> MetresText(double distance_m);

// For the drawings of the detectors.
void DrawRegion(cv::Mat& bgr, const Region& region);
void DrawBox(cv::Mat& bgr, const cv::Rect& box, const std::string& word);
void DrawWord(cv::Mat& bgr, const cv::Point& corner, const std::string& word);

// The condition of all finders: the process ends otherwise.
void CheckCoursePicture(const cv::Mat& bgr);

}  // namespace musher::vision
