#include "musher/modules/vision/course/bar_stripes.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace musher::vision {
namespace {

struct Stripe {
  cv::Rect box;
  cv::Point2d middle;
  double width_px = 0;  // of a stripe that is as high as its box
};

bool IsBetween(double value, double least, double most) {
  return value >= least && value <= most;
}

std::vector<Stripe> StripesOf(const cv::Mat& mask) {
  constexpr double kLeastArea = 12, kLeastHeight = 4;
  constexpr double kNarrowest = 0.4, kLongest = 2.6;  // in heights: a slat is narrower
  constexpr std::size_t kMost = 300;                  // more are a texture
  std::vector<Stripe> pieces;
  for (const Contour& outline : OutlinesOf(mask)) {
    const cv::Rect box = cv::boundingRect(outline);
    if (box.height < kLeastHeight) continue;
    const double area_px2 = cv::contourArea(outline) + cv::arcLength(outline, true) / 2 + 1;
    const double width_px = area_px2 / box.height;
    if (area_px2 < kLeastArea) continue;
    if (!IsBetween(width_px, kNarrowest * box.height, kLongest * box.height)) continue;
    pieces.push_back({box, cv::Point2d(box.tl() + box.br()) / 2, width_px});
  }
  if (pieces.size() > kMost) pieces.clear();
  std::sort(pieces.begin(), pieces.end(),
            [](const Stripe& one, const Stripe& other) { return one.middle.x < other.middle.x; });
  return pieces;
}

// Whether the other one may be the next piece to the right.
bool Follows(const Stripe& one, const Stripe& other) {
  constexpr double kAlike = 1.5, kWidthAlike = 3, kMostSlope = 0.45;
  const cv::Point2d step = other.middle - one.middle;
  const double wide = std::max(one.width_px, other.width_px);
  const double height = double(other.box.height) / one.box.height;
  return IsBetween(step.x, 1.2 * wide, 3.5 * wide) && std::abs(step.y) <= kMostSlope * step.x + 1 &&
         std::abs(step.y) <= 0.6 * std::max(one.box.height, other.box.height) + 1 &&
         IsBetween(height, 1 / kAlike, kAlike) &&
         IsBetween(other.width_px / one.width_px, 1 / kWidthAlike, kWidthAlike);
}

// From that piece to the right, each time to the nearest; takes them.
std::vector<Stripe> TakeRow(std::size_t first, const std::vector<Stripe>& pieces,
                            std::vector<bool>& taken) {
  std::vector<Stripe> row{pieces[first]};
  for (std::size_t i = first + 1; i < pieces.size(); ++i) {
    if (taken[i] || !Follows(row.back(), pieces[i])) continue;
    row.push_back(pieces[i]);
    taken[i] = true;
  }
  return row;
}

struct Sample {
  double value = 0, saturation = 0;
};

// Whether what is between the pieces has the other colour, and there is enough of it.
bool HasGaps(const cv::Mat& hsv, const cv::Mat& mask, const StripedBar& bar,
             const cv::Point2d& from, const cv::Point2d& to, Gaps gaps) {
  std::vector<Sample> between;
  Sample on;
  int count_on = 0;
  const int steps = std::max(1, int(bar.length_px));
  for (int i = 0; i <= steps; ++i) {
    const cv::Point at = from + (to - from) * (double(i) / steps);
    if (!cv::Rect({0, 0}, mask.size()).contains(at)) continue;
    const auto& pixel = hsv.at<cv::Vec3b>(at);
    if (mask.at<std::uint8_t>(at) == 0) {
      between.push_back({double(pixel[2]), double(pixel[1])});
      continue;
    }
    on.value += pixel[2];
    on.saturation += pixel[1];
    ++count_on;
  }
  if (count_on == 0) return false;
  on.value /= count_on;
  on.saturation /= count_on;
  constexpr double kLeastShare = 0.28, kMostShare = 0.78, kLeastFitting = 0.55;
  const double share = double(count_on) / double(count_on + int(between.size()));
  if (!IsBetween(share, kLeastShare, kMostShare)) return false;
  const auto fitting = std::count_if(between.begin(), between.end(), [&](const Sample& gap) {
    return gaps == Gaps::kLight
               ? gap.value > 0.85 * on.value && gap.saturation < 0.62 * on.saturation
               : gap.value < 0.6 * on.value;
  });
  return double(fitting) >= kLeastFitting * double(between.size());
}

// The median of the pieces, without what the box around a tilted one has more.
double HeightOf(const std::vector<Stripe>& row, double slope) {
  std::vector<double> heights;
  for (const Stripe& piece : row) {
    heights.push_back(piece.box.height - piece.width_px * std::abs(slope));
  }
  const auto middle = heights.begin() + std::ptrdiff_t(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

// Along a line that is parallel to the bar's axis, `aside_px` below it, without the outer tenths;
// those in the picture.
std::vector<cv::Point> PointsAlong(const cv::Size& picture, const cv::Point2d& from,
                                   const cv::Point2d& to, double aside_px) {
  std::vector<cv::Point> points;
  const cv::Point2d along = to - from;
  const double length_px = cv::norm(along);
  if (length_px < 1) return points;
  const cv::Point2d below = cv::Point2d(-along.y, along.x) * (aside_px / length_px);
  const int steps = int(length_px);
  for (int i = steps / 10; i <= steps - steps / 10; ++i) {
    const cv::Point at = from + below + along * (double(i) / steps);
    if (cv::Rect({0, 0}, picture).contains(at)) points.push_back(at);
  }
  return points;
}

// Of what does not have the colour of the pieces, along such a line: the means of its strongest and
// its weakest channel.
struct Ground {
  double most = 0, least = 0;
  int count = 0;
};

Ground GroundAlong(const cv::Mat& hsv, const cv::Mat& mask, const cv::Point2d& from,
                   const cv::Point2d& to, double aside_px) {
  Ground ground;
  for (const cv::Point& at : PointsAlong(mask.size(), from, to, aside_px)) {
    if (mask.at<std::uint8_t>(at) != 0) continue;
    const auto& pixel = hsv.at<cv::Vec3b>(at);
    ground.most += pixel[2];
    ground.least += pixel[2] * (1 - pixel[1] / 255.0);
    ++ground.count;
  }
  if (ground.count == 0) return ground;
  ground.most /= ground.count;
  ground.least /= ground.count;
  return ground;
}

// Whether the gaps end where the bar ends. The scene behind a row of things goes on above or below
// it: what is seen between lamps or chairs is as dark or as light as what is beyond them.
bool GapsEnd(const cv::Mat& hsv, const cv::Mat& mask, const cv::Point2d& from,
             const cv::Point2d& to, double aside_px, Gaps gaps) {
  constexpr double kClearly = 1.08, kClearlyPaler = 1.15;
  const Ground gap = GroundAlong(hsv, mask, from, to, 0);
  for (const double aside : {aside_px, -aside_px}) {
    const Ground beyond = GroundAlong(hsv, mask, from, to, aside);
    if (beyond.count == 0) continue;  // outside of the picture
    // Under warm lamps a white gap and what is beyond it are as red as they can be.
    const bool is_lighter =
        gap.most > kClearly * beyond.most || gap.least > kClearlyPaler * beyond.least;
    const bool is_darker = beyond.most > kClearly * gap.most;
    const bool ends = gaps == Gaps::kDark ? is_darker : is_lighter;
    if (!ends) return false;
  }
  return true;
}

std::optional<StripedBar> BarOf(const cv::Mat& hsv, const cv::Mat& mask,
                                const std::vector<Stripe>& row, Gaps gaps) {
  constexpr std::size_t kLeastPieces = 3;
  if (row.size() < kLeastPieces) return std::nullopt;
  StripedBar bar;
  std::vector<cv::Point2f> middles;
  for (const Stripe& piece : row) {
    bar.box = bar.box.empty() ? piece.box : bar.box | piece.box;
    middles.emplace_back(piece.middle);
  }
  cv::Vec4f line;
  cv::fitLine(middles, line, cv::DIST_L2, 0, 0.01, 0.01);
  if (line[0] == 0) return std::nullopt;
  const double slope = line[1] / line[0];
  bar.height_px = HeightOf(row, slope);
  const auto at = [&](double x) { return cv::Point2d(x, line[3] + slope * (x - line[2])); };
  for (const Stripe& piece : row) {
    constexpr double kMostOff = 0.25;  // of its height
    if (std::abs(at(piece.middle.x).y - piece.middle.y) > kMostOff * bar.height_px + 1) {
      return std::nullopt;
    }
  }
  const cv::Point2d from = at(bar.box.x), to = at(bar.box.br().x);
  bar.length_px = cv::norm(to - from);
  bar.tilt_deg = std::abs(std::atan(slope)) * 180 / M_PI;
  if (!HasGaps(hsv, mask, bar, from, to, gaps)) return std::nullopt;
  constexpr double kMostBeside = 0.2;
  const double aside_px = bar.height_px + 2;
  const bool is_alone = ShareAlong(mask, from, to, aside_px) < kMostBeside &&
                        ShareAlong(mask, from, to, -aside_px) < kMostBeside;
  if (!is_alone || !GapsEnd(hsv, mask, from, to, aside_px, gaps)) return std::nullopt;
  return bar;
}

}  // namespace

double ShareAlong(const cv::Mat& mask, const cv::Point2d& from, const cv::Point2d& to,
                  double aside_px) {
  int inside = 0, on = 0;
  for (const cv::Point& at : PointsAlong(mask.size(), from, to, aside_px)) {
    ++inside;
    on += mask.at<std::uint8_t>(at) != 0 ? 1 : 0;
  }
  return inside == 0 ? 0 : double(on) / inside;
}

std::vector<StripedBar> FindStripedBars(const cv::Mat& hsv, const cv::Mat& mask, Gaps gaps) {
  const std::vector<Stripe> pieces = StripesOf(mask);
  std::vector<bool> taken(pieces.size(), false);
  std::vector<StripedBar> bars;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (taken[i]) continue;
    if (const auto bar = BarOf(hsv, mask, TakeRow(i, pieces, taken), gaps)) bars.push_back(*bar);
  }
  return bars;
}

}  // namespace musher::vision
