#include "musher/modules/vision/course/qr_finder.hpp"

#include <ZXing/ReadBarcode.h>
#include <ZXing/TextUtfEncoding.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <utility>

namespace musher::vision {
namespace {

bool IsSign(const cv::Rect& box) {
  constexpr int kLeastHeightPx = 8;
  return box.height >= kLeastHeightPx && box.width < 2 * box.height && box.width * 8 > box.height;
}

// What stands in the same rows as the sign, from neighbour to neighbour. Takes them from `holes`.
std::vector<cv::Rect> TakeLine(const cv::Rect& sign, std::vector<cv::Rect>& holes) {
  std::vector<cv::Rect> line{sign};
  cv::Rect all = sign;
  const int gap = sign.height;
  for (bool grows = true; grows;) {
    const cv::Rect reach(all.x - gap, sign.y, all.width + 2 * gap, sign.height);
    const auto joins = [&](const cv::Rect& hole) {
      const cv::Point middle = (hole.tl() + hole.br()) / 2;
      const bool is_high = hole.height * 5 >= sign.height * 4;
      const bool is_dash = hole.width > hole.height;
      return hole.height <= sign.height && (is_high || is_dash) && (hole & reach).area() > 0 &&
             middle.y >= sign.y && middle.y < sign.br().y;
    };
    const auto next = std::find_if(holes.begin(), holes.end(), joins);
    grows = next != holes.end();
    if (!grows) continue;
    all |= *next;
    line.push_back(*next);
    holes.erase(next);
  }
  return line;
}

// Of the holes in a light area.
void AddLines(std::vector<cv::Rect> holes, std::vector<cv::Rect>& lines) {
  std::sort(holes.begin(), holes.end(),
            [](const auto& one, const auto& other) { return one.height > other.height; });
  while (!holes.empty()) {
    const cv::Rect highest = holes.front();
    holes.erase(holes.begin());
    if (!IsSign(highest)) continue;
    const std::vector<cv::Rect> signs = TakeLine(highest, holes);
    cv::Rect line = highest;
    for (const cv::Rect& sign : signs) line |= sign;
    constexpr std::size_t kMostSigns = 12;
    constexpr int kMostWidth = 8;  // in heights
    if (signs.size() >= 2 && signs.size() <= kMostSigns && line.width > line.height &&
        line.width <= kMostWidth * line.height) {
      lines.push_back(line);
    }
  }
}

// Of a picture of two tones.
void AddLinesOn(const cv::Mat& light, std::vector<cv::Rect>& lines) {
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
  constexpr std::size_t kMostHoles = 400;  // more are a texture
  for (auto& [area, inside] : holes) {
    if (inside.size() <= kMostHoles) AddLines(std::move(inside), lines);
  }
}

bool IsSame(const cv::Rect& one, const cv::Rect& other) {
  return (one & other).area() * 10 > 8 * (one | other).area();
}

// In the picture after scaling.
std::optional<CodeFound> CodeIn(const cv::Mat& grey, double scale) {
  cv::Mat scaled = grey;
  if (scale != 1) cv::resize(grey, scaled, {}, scale, scale, cv::INTER_LINEAR);
  const auto hints = ZXing::DecodeHints().setFormats(ZXing::BarcodeFormat::QRCode);
  const auto code =
      ZXing::ReadBarcode({scaled.data, scaled.cols, scaled.rows, ZXing::ImageFormat::Lum}, hints);
  if (!code.isValid()) return std::nullopt;
  Contour corners;
  for (const auto& corner : code.position()) {
    corners.emplace_back(cvRound(corner.x / scale), cvRound(corner.y / scale));
  }
  return CodeFound{ZXing::TextUtfEncoding::ToUtf8(code.text()), cv::boundingRect(corners)};
}

std::optional<CodeFound> RectifiedCode(const cv::Mat& grey) {
  std::vector<cv::Point2f> corners;
  if (!cv::QRCodeDetector().detect(grey, corners) || corners.size() != 4) return std::nullopt;
  constexpr float kSide = 320, kRim = 40;
  const std::vector<cv::Point2f> square{
      {kRim, kRim}, {kSide - kRim, kRim}, {kSide - kRim, kSide - kRim}, {kRim, kSide - kRim}};
  cv::Mat straight;
  cv::warpPerspective(grey, straight, cv::getPerspectiveTransform(corners, square),
                      {int(kSide), int(kSide)}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  auto code = CodeIn(straight, 1);
  if (!code) {
    cv::threshold(straight, straight, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
    code = CodeIn(straight, 1);
  }
  if (code) code->box = cv::boundingRect(corners);
  return code;
}

}  // namespace

std::optional<CodeFound> FindCode(const cv::Mat& bgr) {
  CheckCoursePicture(bgr);
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  auto code = CodeIn(grey, 1);
  return code ? code : CodeIn(grey, 1.5);
}

std::optional<CodeFound> FindCodeThoroughly(const cv::Mat& bgr) {
  CheckCoursePicture(bgr);
  constexpr int kLeastPx = 21;  // as many squares has the smallest code
  if (bgr.cols < kLeastPx || bgr.rows < kLeastPx) return std::nullopt;
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  auto code = RectifiedCode(grey);
  for (const double scale : {2.0, 3.0}) {
    if (!code) code = CodeIn(grey, scale);
  }
  return code;
}

std::vector<cv::Rect> FindTextLines(const cv::Mat& grey) {
  std::vector<cv::Rect> lines;
  cv::Mat light;
  const double otsu = cv::threshold(grey, light, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  AddLinesOn(light, lines);
  for (const double level : {50.0, 80.0, 110.0, 140.0, 180.0}) {
    constexpr double kNearOtsu = 12;
    if (std::abs(level - otsu) < kNearOtsu) continue;
    cv::threshold(grey, light, level, 255, cv::THRESH_BINARY);
    AddLinesOn(light, lines);
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const auto& one, const auto& other) { return one.area() > other.area(); });
  std::vector<cv::Rect> different;
  constexpr std::size_t kMost = 8;
  for (const cv::Rect& line : lines) {
    const bool is_known = std::any_of(different.begin(), different.end(),
                                      [&](const cv::Rect& each) { return IsSame(line, each); });
    if (!is_known && different.size() < kMost) different.push_back(line);
  }
  return different;
}

}  // namespace musher::vision
