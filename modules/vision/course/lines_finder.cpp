#include "musher/modules/vision/course/lines_finder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

namespace musher::vision {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

struct YellowLine {
  Contour outline;  // in the region
  double area_px2 = 0;
  cv::Point2d centroid;
};

// The largest ones, the largest first.
std::vector<YellowLine> LinesOf(const cv::Mat& mask, const LinesParameters& parameters) {
  std::vector<YellowLine> lines;
  for (Contour& outline : OutlinesOf(mask)) {
    const cv::Moments moments = cv::moments(outline);
    if (moments.m00 <= 0 || moments.m00 < parameters.least_area_px2) continue;
    const cv::Rect box = cv::boundingRect(outline);
    if (box.width < parameters.least_length * box.height) continue;
    lines.push_back(
        {std::move(outline), moments.m00, {moments.m10 / moments.m00, moments.m01 / moments.m00}});
  }
  std::stable_sort(lines.begin(), lines.end(), [](const auto& one, const auto& other) {
    return one.area_px2 > other.area_px2;
  });
  const auto most = static_cast<std::size_t>(std::max(0, parameters.most_lines));
  if (lines.size() > most) lines.resize(most);
  return lines;
}

// The middle of the lane, from its place, as a share of the width.
double MiddleOffset(const std::vector<YellowLine>& lines, int width,
                    const LinesParameters& parameters) {
  // Of the middles of pixels: (width - 1) / 2 is that of the region.
  const double center_x = (width - 1) / 2.0 + (parameters.ycy_center - 0.5) * width;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double leftmost = kFar, rightmost = -kFar, left = -kFar, right = kFar;
  for (const YellowLine& line : lines) {
    const double x = line.centroid.x;
    leftmost = std::min(leftmost, x);
    rightmost = std::max(rightmost, x);
    if (x <= center_x) left = std::max(left, x);
    if (x >= center_x) right = std::min(right, x);
  }
  const bool between = left > -kFar && right < kFar;
  const double middle = parameters.ycy_pair == LanePair::kInnermost && between
                            ? (left + right) / 2
                            : (leftmost + rightmost) / 2;
  return (middle - center_x) / width;
}

std::string Ycy(double middle_offset, bool single, double threshold) {
  if (single) return middle_offset < 0 ? "left" : middle_offset > 0 ? "right" : "center";
  if (middle_offset > threshold) return "left";
  return middle_offset < -threshold ? "right" : "center";
}

std::string Dy(double line_offset, double threshold) {
  if (line_offset < -threshold) return "front";
  return line_offset > threshold ? "back" : "center";
}

// The lowest pixel of the lines in each of some columns.
void AddEdge(const cv::Mat& mask, const std::vector<YellowLine>& lines, const cv::Rect& region,
             const cv::Size& picture, int columns, msg::YellowLines& message) {
  cv::Mat filled = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (const YellowLine& line : lines) {
    cv::drawContours(filled, std::vector<Contour>{line.outline}, 0, cv::Scalar(255), cv::FILLED);
  }
  for (int i = 0; i < columns; ++i) {
    const int x = std::min(mask.cols - 1, static_cast<int>((i + 0.5) * mask.cols / columns));
    int y = mask.rows - 1;
    while (y >= 0 && !(filled.at<std::uint8_t>(y, x) && mask.at<std::uint8_t>(y, x))) --y;
    if (y < 0) continue;
    message.edge_x.push_back(static_cast<float>((region.x + x + 0.5) / picture.width));
    message.edge_y.push_back(static_cast<float>((region.y + y + 0.5) / picture.height));
  }
}

}  // namespace

LinesFound FindLines(const cv::Mat& bgr, const LinesParameters& parameters) {
  CheckCoursePicture(bgr);
  const cv::Rect region = RectOf(parameters.region, bgr.size());
  cv::Mat mask = MaskOf(bgr(region), parameters.yellow);
  constexpr int kKernelPx = 3;
  CleanMask(mask, kKernelPx, kKernelPx);
  std::vector<YellowLine> lines = LinesOf(mask, parameters);

  LinesFound found;
  msg::YellowLines& message = found.lines;
  message.contours = static_cast<std::uint32_t>(lines.size());
  message.ycy = message.dy = message.walk = "center";
  message.middle_offset = message.line_offset = message.bottom_gap_px = kUnknown;
  if (lines.empty()) return found;

  const double middle_offset = MiddleOffset(lines, region.width, parameters);
  message.middle_offset = static_cast<float>(middle_offset);
  message.ycy = Ycy(middle_offset, lines.size() == 1, parameters.ycy_threshold);

  const double center_x = (region.width - 1) / 2.0;
  const auto nearest =
      std::min_element(lines.begin(), lines.end(), [&](const auto& one, const auto& other) {
        return std::abs(one.centroid.x - center_x) < std::abs(other.centroid.x - center_x);
      });
  const double line_offset = (nearest->centroid.y + 0.5) / region.height - parameters.dy_target;
  message.line_offset = static_cast<float>(line_offset);
  message.dy = Dy(line_offset, parameters.dy_threshold);
  const cv::Rect box = cv::boundingRect(nearest->outline);
  const double gap_px = bgr.rows - (region.y + box.y + box.height);
  message.bottom_gap_px = static_cast<float>(gap_px);
  if (gap_px < parameters.walk_bottom_px) {
    message.walk = "back";
  } else if (std::abs(nearest->centroid.x - center_x) > parameters.walk_x_px) {
    message.walk = "front";
  }
  for (const YellowLine& line : lines) message.area_px2 += static_cast<float>(line.area_px2);
  AddEdge(mask, lines, region, bgr.size(), parameters.edge_columns, message);
  for (YellowLine& line : lines) {
    for (cv::Point& point : line.outline) point += region.tl();
    found.outlines.push_back(std::move(line.outline));
  }
  return found;
}

}  // namespace musher::vision
