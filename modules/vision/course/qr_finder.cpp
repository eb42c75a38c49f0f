#include "musher/modules/vision/course/qr_finder.hpp"

#include <ZXing/ReadBarcode.h>
#include <ZXing/TextUtfEncoding.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace musher::vision {
namespace {

// The holes of a light area that make one line: as high as the highest one's rows.
std::optional<cv::Rect> LineOf(const std::vector<cv::Rect>& holes) {
  const auto highest = std::max_element(
      holes.begin(), holes.end(),
      [](const auto& one, const auto& other) { return one.height < other.height; });
  constexpr int kLeastHeightPx = 8;
  if (highest->height < kLeastHeightPx) return std::nullopt;
  cv::Rect line = *highest;
  int signs = 0;
  for (const cv::Rect& hole : holes) {
    const int middle = hole.y + hole.height / 2;
    if (middle < highest->y || middle >= highest->br().y) continue;
    line |= hole;
    ++signs;
  }
  constexpr int kMostSigns = 24;
  const double ratio = double(line.width) / line.height;
  if (signs < 2 || signs > kMostSigns || ratio < 0.8 || ratio > 12) return std::nullopt;
  return line;
}

// Of a picture of two tones.
void AddPlates(const cv::Mat& light, std::vector<Plate>& plates) {
  std::vector<Contour> outlines;
  std::vector<cv::Vec4i> tree;  // next, previous, first child, parent
  cv::findContours(light, outlines, tree, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
  std::map<int, std::vector<cv::Rect>> holes;  // by the area that they are in
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    constexpr std::size_t kLeastCorners = 4;
    const int parent = tree[i][3];
    if (parent >= 0 && outlines[i].size() >= kLeastCorners) {
      holes[parent].push_back(cv::boundingRect(outlines[i]));
    }
  }
  for (const auto& [area, inside] : holes) {
    const auto line = LineOf(inside);
    if (!line) continue;
    Plate plate{*line, {}};
    cv::convexHull(outlines[static_cast<std::size_t>(area)], plate.outline);
    plates.push_back(std::move(plate));
  }
}

bool IsSame(const cv::Rect& one, const cv::Rect& other) {
  return (one & other).area() * 10 > 8 * (one | other).area();
}

std::optional<CodeFound> CodeIn(const cv::Mat& grey, int scale) {
  const auto hints = ZXing::DecodeHints().setFormats(ZXing::BarcodeFormat::QRCode);
  const auto code =
      ZXing::ReadBarcode({grey.data, grey.cols, grey.rows, ZXing::ImageFormat::Lum}, hints);
  if (!code.isValid()) return std::nullopt;
  Contour corners;
  for (const auto& corner : code.position()) {
    corners.emplace_back(corner.x * scale, corner.y * scale);
  }
  return CodeFound{ZXing::TextUtfEncoding::ToUtf8(code.text()), cv::boundingRect(corners)};
}

}  // namespace

std::optional<CodeFound> FindCode(const cv::Mat& bgr) {
  CheckCoursePicture(bgr);
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  if (auto code = CodeIn(grey, 1)) return code;
  // A near code is read better where its squares have fewer pixels, and less noise.
  if (grey.cols < 2 || grey.rows < 2) return std::nullopt;
  cv::Mat half;
  cv::resize(grey, half, {grey.cols / 2, grey.rows / 2}, 0, 0, cv::INTER_AREA);
  return CodeIn(half, 2);
}

std::vector<Plate> FindPlates(const cv::Mat& grey) {
  std::vector<Plate> plates;
  cv::Mat light;
  const double otsu = cv::threshold(grey, light, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  AddPlates(light, plates);
  for (const double level : {50.0, 80.0, 110.0, 140.0, 180.0}) {
    constexpr double kNearOtsu = 12;
    if (std::abs(level - otsu) < kNearOtsu) continue;
    cv::threshold(grey, light, level, 255, cv::THRESH_BINARY);
    AddPlates(light, plates);
  }
  std::stable_sort(plates.begin(), plates.end(), [](const auto& one, const auto& other) {
    return one.line.area() > other.line.area();
  });
  std::vector<Plate> different;
  constexpr std::size_t kMost = 6;
  for (Plate& plate : plates) {
    const bool is_known = std::any_of(different.begin(), different.end(), [&](const Plate& each) {
      return IsSame(plate.line, each.line);
    });
    if (!is_known && different.size() < kMost) different.push_back(std::move(plate));
  }
  return different;
}

}  // namespace musher::vision
