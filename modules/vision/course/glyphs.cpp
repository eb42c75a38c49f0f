#include "musher/modules/vision/course/glyphs.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace musher::vision {
namespace {

// Of the high signs, from left to right; ink is 255. A dash is low, and left out.
std::vector<cv::Mat> GlyphsOf(const cv::Mat& letters, double letter_px) {
  constexpr double kHigh = 0.6;
  const cv::Mat ink = 255 - letters;
  cv::Mat labels, stats, centers;
  const int count = cv::connectedComponentsWithStats(ink, labels, stats, centers);
  std::vector<std::pair<int, int>> by_left;  // its left edge, its label
  for (int i = 1; i < count; ++i) {
    if (stats.at<int>(i, cv::CC_STAT_HEIGHT) < kHigh * letter_px) continue;
    by_left.emplace_back(stats.at<int>(i, cv::CC_STAT_LEFT), i);
  }
  std::sort(by_left.begin(), by_left.end());
  std::vector<cv::Mat> glyphs;
  for (const auto& [left, i] : by_left) {
    const cv::Rect box(left, stats.at<int>(i, cv::CC_STAT_TOP), stats.at<int>(i, cv::CC_STAT_WIDTH),
                       stats.at<int>(i, cv::CC_STAT_HEIGHT));
    glyphs.push_back(labels(box) == i);
  }
  return glyphs;
}

// Where the ink of these rows is, on average, from its left edge; rows as shares of its height.
double MiddleOf(const cv::Mat& glyph, double from, double to) {
  const cv::Moments ink =
      cv::moments(glyph.rowRange(cvRound(from * glyph.rows), cvRound(to * glyph.rows)), true);
  return ink.m00 > 0 ? ink.m10 / ink.m00 : 0;
}

// How far its ink moves to the left from its upper to its lower half, as a share of its height: a 1
// has a stem, a 2 a stroke from the upper right to the lower left.
double LeanOf(const cv::Mat& glyph) {
  return (MiddleOf(glyph, 0.28, 0.45) - MiddleOf(glyph, 0.62, 0.8)) / glyph.rows;
}

// How far its left side is from a straight line, at most, as a share of its height; without its
// ends, where it may have serifs.
double LeftBendOf(const cv::Mat& glyph) {
  constexpr double kEnds = 0.17;
  std::vector<cv::Point2f> side;
  for (int y = cvRound(kEnds * glyph.rows); y < cvRound((1 - kEnds) * glyph.rows); ++y) {
    const auto* row = glyph.ptr<std::uint8_t>(y);
    const auto* first = std::find(row, row + glyph.cols, 255);
    side.emplace_back(float(first - row), float(y));
  }
  if (side.size() < 2) return 1;
  cv::Vec4f line;
  cv::fitLine(side, line, cv::DIST_L1, 0, 0.01, 0.01);
  double most = 0;
  for (const cv::Point2f& at : side) {
    const double off = (at.x - line[2]) * line[1] - (at.y - line[3]) * line[0];
    most = std::max(most, std::abs(off) / glyph.rows);
  }
  return most;
}

bool Fits(const cv::Mat& glyph, char letter) {
  constexpr double kMostLeanOfOne = 0.08, kLeastLeanOfTwo = 0.12, kMostBend = 0.055;
  switch (letter) {
    case '1':
      return std::abs(LeanOf(glyph)) <= kMostLeanOfOne;
    case '2':
      return LeanOf(glyph) >= kLeastLeanOfTwo;
    case 'B':
      return LeftBendOf(glyph) <= kMostBend;
    case '8':
      return LeftBendOf(glyph) > kMostBend;
    default:
      return true;
  }
}

}  // namespace

bool GlyphsFit(const cv::Mat& letters, double letter_px, const std::string& word) {
  std::string signs;
  for (const char c : word) {
    if (static_cast<unsigned char>(c) >= 0x80) return true;
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) signs += c;
  }
  const std::vector<cv::Mat> glyphs = GlyphsOf(letters, letter_px);
  if (glyphs.size() != signs.size()) return false;
  for (std::size_t i = 0; i < signs.size(); ++i) {
    if (!Fits(glyphs[i], signs[i])) return false;
  }
  return true;
}

}  // namespace musher::vision
