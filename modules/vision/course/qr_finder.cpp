#include "musher/modules/vision/course/qr_finder.hpp"

#include <ZXing/ReadBarcode.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <utility>

#include "musher/modules/vision/course/zbar_codes.hpp"

namespace musher::vision {
namespace {

struct Sign {
  cv::Rect box;
  double area = 0;     // inside of its outline
  double darkest = 0;  // of its pixels
};

bool IsLetter(const cv::Rect& box) {
  constexpr int kLeastHeightPx = 8;
  return box.height >= kLeastHeightPx && box.width < 2 * box.height && box.width * 8 > box.height;
}

// Whether it stands in the same rows as the letter, at the end of the line, in the same ink.
bool Continues(const cv::Rect& line, const Sign& letter, const Sign& sign) {
  constexpr double kSameInk = 15;
  const int gap = letter.box.height / 2;
  const cv::Rect reach(line.x - gap, letter.box.y, line.width + 2 * gap, letter.box.height);
  const int middle = sign.box.y + sign.box.height / 2;
  const bool is_high = sign.box.height * 5 >= letter.box.height * 4;
  const bool is_dash = sign.box.width > sign.box.height;
  return sign.box.height <= letter.box.height && (is_high || is_dash) &&
         (sign.box & reach).area() > 0 && middle >= letter.box.y && middle < letter.box.br().y &&
         std::abs(sign.darkest - letter.darkest) < kSameInk;
}

// The line of that letter, from neighbour to neighbour. Takes them from `signs`.
std::optional<cv::Rect> TakeLine(const Sign& letter, std::vector<Sign>& signs) {
  cv::Rect line = letter.box;
  std::size_t count = 1;
  const auto next = [&] {
    return std::find_if(signs.begin(), signs.end(),
                        [&](const Sign& sign) { return Continues(line, letter, sign); });
  };
  for (auto sign = next(); sign != signs.end(); sign = next()) {
    line |= sign->box;
    ++count;
    signs.erase(sign);
  }
  constexpr std::size_t kMostSigns = 12;
  constexpr int kMostWidth = 8;  // in heights
  const bool is_line = count >= 2 && count <= kMostSigns && line.width > line.height &&
                       line.width <= kMostWidth * line.height;
  return is_line ? std::optional(line) : std::nullopt;
}

// Of the signs on one light area.
void AddLines(std::vector<Sign> signs, std::vector<TextLine>& lines) {
  const std::vector<Sign> all = signs;
  std::sort(signs.begin(), signs.end(),
            [](const auto& one, const auto& other) { return one.box.height > other.box.height; });
  while (!signs.empty()) {
    const Sign highest = signs.front();
    signs.erase(signs.begin());
    if (!IsLetter(highest.box)) continue;
    const auto line = TakeLine(highest, signs);
    if (!line) continue;
    const bool alone = std::none_of(all.begin(), all.end(), [&](const Sign& sign) {
      return (sign.box & *line).empty() && IsLetter(sign.box) && 2 * sign.box.height > line->height;
    });
    lines.push_back({*line, alone});
  }
}

// Whether it has four corners, as a board has from everywhere.
bool IsQuad(const Contour& hull) {
  constexpr double kLeastShare = 0.88;
  const double around = cv::arcLength(hull, true);
  for (const double share : {0.02, 0.035, 0.05, 0.07}) {
    Contour corners;
    cv::approxPolyDP(hull, corners, share * around, true);
    if (corners.size() > 4) continue;
    return corners.size() == 4 && cv::contourArea(corners) > kLeastShare * cv::contourArea(hull);
  }
  return false;
}

// Whether the light area has four corners and no dents, as a board, and few signs on it.
bool IsBoard(const Contour& outline, const std::vector<Sign>& signs) {
  constexpr double kLeastShareOfHull = 0.85, kMostShareOfSigns = 0.35;
  Contour hull;
  cv::convexHull(outline, hull);
  const double area = cv::contourArea(outline);
  double dark = 0;
  for (const Sign& sign : signs) dark += sign.area;
  return area > kLeastShareOfHull * cv::contourArea(hull) && dark < kMostShareOfSigns * area &&
         IsQuad(hull);
}

// Whether the area, without its holes, has one brightness: not stones that are brighter than the
// level.
bool IsPlain(const cv::Mat& grey, const std::vector<Contour>& outlines,
             const std::vector<cv::Vec4i>& tree, int area) {
  constexpr double kMostDeviation = 0.25;  // as a share of its mean
  cv::Mat mask = cv::Mat::zeros(grey.size(), CV_8UC1);
  cv::drawContours(mask, outlines, area, 255, cv::FILLED);
  for (int hole = tree[std::size_t(area)][2]; hole >= 0; hole = tree[std::size_t(hole)][0]) {
    cv::drawContours(mask, outlines, hole, 0, cv::FILLED);
  }
  cv::Scalar mean, deviation;
  cv::meanStdDev(grey, mean, deviation, mask);
  return deviation[0] < kMostDeviation * mean[0];
}

// Of the light areas that are brighter than that level.
void AddLinesAt(double level, const cv::Mat& grey, std::vector<TextLine>& lines) {
  cv::Mat light;
  cv::threshold(grey, light, level, 255, cv::THRESH_BINARY);
  std::vector<Contour> outlines;
  std::vector<cv::Vec4i> tree;  // next, previous, first child, parent
  cv::findContours(light, outlines, tree, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
  std::map<int, std::vector<Sign>> holes;  // by the area that they are in
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    constexpr std::size_t kLeastCorners = 4;
    const int parent = tree[i][3];
    if (parent < 0 || outlines[i].size() < kLeastCorners) continue;
    Sign sign{cv::boundingRect(outlines[i]), cv::contourArea(outlines[i])};
    cv::minMaxLoc(grey(sign.box), &sign.darkest);
    holes[parent].push_back(sign);
  }
  constexpr std::size_t kMostHoles = 400;  // more are a texture
  for (auto& [area, signs] : holes) {
    if (signs.size() > kMostHoles || !IsBoard(outlines[std::size_t(area)], signs)) continue;
    std::vector<TextLine> found;
    AddLines(std::move(signs), found);
    if (found.empty() || !IsPlain(grey, outlines, tree, area)) continue;
    // A light area as large as the picture is more than a board: a fence in it is no second word.
    constexpr double kWhole = 0.9;
    const cv::Rect board = cv::boundingRect(outlines[std::size_t(area)]);
    const bool is_whole = board.area() > kWhole * double(grey.total());
    for (TextLine& line : found) line.alone = line.alone || is_whole;
    lines.insert(lines.end(), found.begin(), found.end());
  }
}

bool IsSame(const cv::Rect& one, const cv::Rect& other) {
  return (one & other).area() * 10 > 8 * (one | other).area();
}

#if __has_include(<ZXing/ReaderOptions.h>)  // from ZXing 2.2 on
using CodeOptions = ZXing::ReaderOptions;
#else
using CodeOptions = ZXing::DecodeHints;
#endif

std::optional<CodeFound> LargestOf(std::vector<CodeFound> codes) {
  if (codes.empty()) return std::nullopt;
  std::ranges::stable_sort(codes, [](const CodeFound& one, const CodeFound& other) {
    return one.box.area() > other.box.area();
  });
  CodeFound largest = std::move(codes.front());
  codes.erase(codes.begin());
  largest.smaller = std::move(codes);
  return largest;
}

// The largest in the picture after scaling.
std::optional<CodeFound> CodeIn(const cv::Mat& grey, double scale) {
  cv::Mat scaled = grey;
  if (scale != 1) cv::resize(grey, scaled, {}, scale, scale, cv::INTER_CUBIC);
  const auto options = CodeOptions().setFormats(ZXing::BarcodeFormat::QRCode);
  std::vector<CodeFound> codes;
  for (const auto& code : ZXing::ReadBarcodes(
           {scaled.data, scaled.cols, scaled.rows, ZXing::ImageFormat::Lum}, options)) {
    if (!code.isValid()) continue;
    Contour corners;
    for (const auto& corner : code.position()) {
      corners.emplace_back(cvRound(corner.x / scale), cvRound(corner.y / scale));
    }
    codes.push_back({code.text(), cv::boundingRect(corners)});
  }
  return LargestOf(std::move(codes));
}

// `corners`: of the code, by its finder patterns.
std::optional<CodeFound> RectifiedCode(const cv::Mat& grey,
                                       const std::vector<cv::Point2f>& corners) {
  if (corners.size() != 4) return std::nullopt;
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

ThoroughLook LookThoroughly(const cv::Mat& bgr) {
  CheckCoursePicture(bgr);
  constexpr int kLeastPx = 21;  // as many squares has the smallest code
  if (bgr.cols < kLeastPx || bgr.rows < kLeastPx) return {};
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  ThoroughLook look;
  std::vector<cv::Point2f> corners;
  look.shows_patterns = cv::QRCodeDetector().detect(grey, corners);
  if (look.shows_patterns) look.code = RectifiedCode(grey, corners);
  if (look.shows_patterns && !look.code) look.code = LargestOf(CodesOfZBar(grey));
  for (const double scale : {3.0, 2.0}) {
    if (!look.code) look.code = CodeIn(grey, scale);
  }
  constexpr double kInvertedScale = 1.5;
  if (!look.code) look.code = CodeIn(255 - grey, kInvertedScale);
  return look;
}

std::optional<CodeFound> FindCodeThoroughly(const cv::Mat& bgr) {
  return LookThoroughly(bgr).code;
}

std::vector<TextLine> FindTextLines(const cv::Mat& grey) {
  std::vector<TextLine> lines;
  cv::Mat light;
  const double otsu = cv::threshold(grey, light, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  AddLinesAt(otsu, grey, lines);
  for (const double level : {50.0, 80.0, 110.0, 140.0, 180.0}) {
    constexpr double kNearOtsu = 12;
    if (std::abs(level - otsu) > kNearOtsu) AddLinesAt(level, grey, lines);
  }
  std::stable_sort(lines.begin(), lines.end(), [](const auto& one, const auto& other) {
    return one.box.area() > other.box.area();
  });
  // At another level its board may show fewer signs.
  for (TextLine& line : lines) {
    line.alone = std::all_of(lines.begin(), lines.end(), [&](const TextLine& each) {
      return each.alone || !IsSame(each.box, line.box);
    });
  }
  std::vector<TextLine> different;
  constexpr std::size_t kMost = 8;
  for (const TextLine& line : lines) {
    const bool is_known =
        std::any_of(different.begin(), different.end(),
                    [&](const TextLine& each) { return IsSame(line.box, each.box); });
    if (!is_known && different.size() < kMost) different.push_back(line);
  }
  return different;
}

}  // namespace musher::vision
