#include "musher/modules/vision/course/color_mask.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>

#include "musher/base/check.hpp"

namespace musher::vision {
namespace {

constexpr double kNormalWidthPx = 640;
const cv::Scalar kRegionColor(255, 160, 0);
const cv::Scalar kBoxColor(255, 0, 255);

int Pixel(double share, int length) {
  return std::clamp(static_cast<int>(std::lround(share * length)), 0, length);
}

cv::Scalar ScalarOf(const std::array<int, 3>& hsv) {
  return {double(hsv[0]), double(hsv[1]), double(hsv[2])};
}

}  // namespace

cv::Rect RectOf(const Region& region, const cv::Size& picture) {
  const int left = std::min(Pixel(region.left, picture.width), picture.width - 1);
  const int top = std::min(Pixel(region.top, picture.height), picture.height - 1);
  const int right = std::max(Pixel(region.right, picture.width), left + 1);
  const int bottom = std::max(Pixel(region.bottom, picture.height), top + 1);
  return {left, top, right - left, bottom - top};
}

cv::Mat MaskOf(const cv::Mat& bgr, const HsvRange& range) {
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
  return MaskOfHsv(hsv, range);
}

cv::Mat MaskOfHsv(const cv::Mat& hsv, const HsvRange& range) {
  cv::Mat mask;
  if (range.from[0] <= range.to[0]) {
    cv::inRange(hsv, ScalarOf(range.from), ScalarOf(range.to), mask);
    return mask;
  }
  cv::Mat above;
  cv::inRange(hsv, ScalarOf({0, range.from[1], range.from[2]}), ScalarOf(range.to), mask);
  cv::inRange(hsv, ScalarOf(range.from), ScalarOf({179, range.to[1], range.to[2]}), above);
  cv::bitwise_or(mask, above, mask);
  return mask;
}

bool IsIn(const cv::Vec3b& hsv, const HsvRange& range) {
  const bool goes_through_0 = range.from[0] > range.to[0];
  const bool from = hsv[0] >= range.from[0], to = hsv[0] <= range.to[0];
  return (goes_through_0 ? from || to : from && to) && hsv[1] >= range.from[1] &&
         hsv[1] <= range.to[1] && hsv[2] >= range.from[2] && hsv[2] <= range.to[2];
}

void CleanMask(cv::Mat& mask, int open_px, int close_px) {
  const auto square = [](int side_px) {
    return cv::getStructuringElement(cv::MORPH_RECT, {side_px, side_px});
  };
  if (open_px > 1) cv::morphologyEx(mask, mask, cv::MORPH_OPEN, square(open_px));
  if (close_px > 1) cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, square(close_px));
}

std::vector<Contour> OutlinesOf(const cv::Mat& mask) {
  std::vector<Contour> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  return outlines;
}

double DistanceBySizeM(const std::optional<Lens>& lens, const cv::Size& picture, double size_px,
                       double size_m, double focal_px) {
  if (!(size_px > 0)) return std::numeric_limits<double>::quiet_NaN();
  const double focal =
      lens ? lens->focal_y * picture.height : focal_px * picture.width / kNormalWidthPx;
  return focal * size_m / size_px;
}

float ConfidenceBy(std::initializer_list<double> margins) {
  const double least = std::min(margins);
  return float(std::isfinite(least) ? 0.5 + std::clamp(least, 0.0, 1.0) / 2 : 0.5);
}

msg::Sighting SightingAt(const cv::Rect& box, const cv::Size& picture) {
  msg::Sighting sighting = NoSighting();
  sighting.seen = true;
  sighting.confidence = ConfidenceBy({0});
  sighting.x = float(box.x) / float(picture.width);
  sighting.y = float(box.y) / float(picture.height);
  sighting.width = float(box.width) / float(picture.width);
  sighting.height = float(box.height) / float(picture.height);
  return sighting;
}

msg::Sighting NoSighting() {
  msg::Sighting sighting;
  sighting.distance_m = std::numeric_limits<float>::quiet_NaN();
  return sighting;
}

std::optional<std::string> MetresText(double distance_m) {
  if (!std::isfinite(distance_m)) return std::nullopt;
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", distance_m);
  return text;
}

void DrawRegion(cv::Mat& bgr, const Region& region) {
  cv::rectangle(bgr, RectOf(region, bgr.size()), kRegionColor, 1);
}

void DrawBox(cv::Mat& bgr, const cv::Rect& box, const std::string& word) {
  cv::rectangle(bgr, box, kBoxColor, 2);
  DrawWord(bgr, box.tl(), word);
}

// Over the corner, or below it where there is no room.
void DrawWord(cv::Mat& bgr, const cv::Point& corner, const std::string& word) {
  constexpr int kLetterPx = 16;
  const int longest_px = 10 * static_cast<int>(word.size());
  const cv::Point at(std::clamp(corner.x, 2, std::max(2, bgr.cols - longest_px)),
                     corner.y > 2 * kLetterPx ? corner.y - 6 : corner.y + kLetterPx + 4);
  cv::putText(bgr, word, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, kBoxColor, 1, cv::LINE_AA);
}

void CheckCoursePicture(const cv::Mat& bgr) {
  MUSHER_CHECK(!bgr.empty() && bgr.type() == CV_8UC3, "picture", bgr.cols, bgr.rows, bgr.type());
}

}  // namespace musher::vision
