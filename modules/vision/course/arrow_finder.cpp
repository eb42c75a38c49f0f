#include "musher/modules/vision/course/arrow_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "musher/modules/vision/course/arrow_shapes.hpp"

namespace musher::vision {
namespace {

constexpr int kBins = 24;  // along the arrow's axis
using Profile = std::array<double, kBins>;

// From level; 0 when the thing is not clearly longer in one direction, or stands upright.
double TiltOf(const cv::Moments& moments) {
  constexpr double kMostTilt = M_PI / 6;
  const double tilt = std::atan2(2 * moments.mu11, moments.mu20 - moments.mu02) / 2;
  const double spread = std::hypot(2 * moments.mu11, moments.mu20 - moments.mu02);
  constexpr double kLeastSpread = 0.3;
  if (spread < kLeastSpread * (moments.mu20 + moments.mu02)) return 0;
  return std::abs(tilt) <= kMostTilt ? tilt : 0;
}

// How high the green is at each place along the axis, as a share of the highest. Nothing when it is
// too small, or not alike on both sides of the axis.
std::optional<Profile> ProfileOf(const cv::Mat& green, double tilt_rad) {
  std::vector<cv::Point> pixels;
  cv::findNonZero(green, pixels);
  const double cosine = std::cos(tilt_rad), sine = std::sin(tilt_rad);
  const auto along = [&](const cv::Point& pixel) { return pixel.x * cosine + pixel.y * sine; };
  const auto aside = [&](const cv::Point& pixel) { return pixel.y * cosine - pixel.x * sine; };
  double least = along(pixels.front()), most = least, middle = 0;
  for (const cv::Point& pixel : pixels) {
    least = std::min(least, along(pixel));
    most = std::max(most, along(pixel));
    middle += aside(pixel) / static_cast<double>(pixels.size());
  }
  const double bin_px = (most - least + 1) / kBins;
  if (bin_px < 1) return std::nullopt;
  Profile profile{}, lever{};
  for (const cv::Point& pixel : pixels) {
    // A pixel is one pixel long, and may lie in two bins.
    const double from = (along(pixel) - least) / bin_px, to = from + 1 / bin_px;
    const auto bin = static_cast<std::size_t>(std::min<double>(from, kBins - 1));
    const double rest = std::max(0.0, to - double(bin + 1));
    for (const auto& [at, share] : {std::pair(bin, to - from - rest), std::pair(bin + 1, rest)}) {
      if (at >= kBins) continue;
      profile[at] += share;
      lever[at] += share * (aside(pixel) - middle);
    }
  }
  const double highest = *std::max_element(profile.begin(), profile.end());
  double askew = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    askew += std::abs(lever[i]) / (highest * highest * kBins);
    profile[i] /= highest;
  }
  constexpr double kMostAskew = 0.05;
  if (askew > kMostAskew) return std::nullopt;
  return profile;
}

// The mean difference from the best fitting arrow that points to the right.
double MisfitOf(const Profile& profile) {
  double best = 1;
  constexpr int kParts = 20;  // of the length and of the height
  for (int head_parts = 4; head_parts <= 15; ++head_parts) {
    for (int shaft_parts = 3; shaft_parts <= 14; ++shaft_parts) {
      const double head = static_cast<double>(head_parts) / kParts;
      const double shaft = static_cast<double>(shaft_parts) / kParts;
      double sum = 0;
      for (int i = 0; i < kBins; ++i) {
        const double at = (i + 0.5) / kBins;
        const double model = at < 1 - head ? shaft : (1 - at) / head;
        sum += std::abs(model - profile[static_cast<std::size_t>(i)]);
      }
      best = std::min(best, sum / kBins);
    }
  }
  return best;
}

// Whether almost nothing of what is around it is nearly green: a board, no leaves.
bool StandsAlone(const cv::Mat& bgr, const cv::Mat& mask, const cv::Rect& box) {
  const cv::Rect around = cv::Rect(box.x - box.width / 8 - 3, box.y - box.height / 8 - 3,
                                   box.width + box.width / 4 + 6, box.height + box.height / 4 + 6) &
                          cv::Rect({0, 0}, bgr.size());
  const int others = around.area() - box.area();
  const int green = cv::countNonZero(mask(around)) - cv::countNonZero(mask(box));
  constexpr double kMostGreen = 0.05;
  return others > 0 && green < kMostGreen * others;
}

struct Direction {
  bool left = false;
  double misfit = 0;
  double margin = 0;
};

// `worse`: what fits second best.
double MarginOf(double misfit, double most, double worse, double clearly) {
  return std::min(1 - misfit / most, 1 - clearly * misfit / std::max(worse, misfit));
}

// The same thing on a level axis, on a larger picture.
cv::Mat Levelled(const cv::Mat& shape, double tilt_rad) {
  const int rim_px = std::max(shape.cols, shape.rows) / 2;
  cv::Mat level;
  cv::copyMakeBorder(shape, level, rim_px, rim_px, rim_px, rim_px, cv::BORDER_CONSTANT);
  const cv::Point2f middle(float(level.cols) / 2, float(level.rows) / 2);
  const cv::Mat turn = cv::getRotationMatrix2D(middle, tilt_rad * 180 / M_PI, 1);
  cv::warpAffine(level, level, turn, level.size(), cv::INTER_NEAREST);
  return level;
}

// Whether the whole silhouette is more like such an arrow than like anything else: leaves have the
// heights of an arrow by chance.
bool LooksLike(const Direction& direction, const cv::Mat& shape, double tilt_rad) {
  constexpr double kMostMisfit = 0.3;
  const auto misfits = CompareShapes(Levelled(shape, tilt_rad));
  if (!misfits) return false;
  const double own = direction.left ? misfits->left : misfits->right;
  const double opposite = direction.left ? misfits->right : misfits->left;
  return own < kMostMisfit && own < opposite && own < misfits->other;
}

// By the heights along its axis: of a straight arrow whose shaft has one height.
std::optional<Direction> ByProfile(const cv::Mat& shape, const ArrowParameters& parameters) {
  const double tilt_rad = TiltOf(cv::moments(shape, true));
  auto profile = ProfileOf(shape, tilt_rad);
  if (!profile) return std::nullopt;
  const double right = MisfitOf(*profile);
  std::reverse(profile->begin(), profile->end());
  const double left = MisfitOf(*profile);
  const double misfit = std::min(left, right);
  if (misfit > parameters.most_misfit) return std::nullopt;
  if (std::max(left, right) < parameters.clearly * misfit) return std::nullopt;
  const double margin =
      MarginOf(misfit, parameters.most_misfit, std::max(left, right), parameters.clearly);
  const Direction direction{left < right, misfit, margin};
  return LooksLike(direction, shape, tilt_rad) ? std::optional(direction) : std::nullopt;
}

// By the whole silhouette.
std::optional<Direction> ByShape(const cv::Mat& shape, const ArrowParameters& parameters) {
  const auto misfits = CompareShapes(shape);
  if (!misfits) return std::nullopt;
  const double best = std::min(misfits->left, misfits->right);
  const double worse = std::max(misfits->left, misfits->right);
  if (best > parameters.most_shape_misfit) return std::nullopt;
  const double second = std::min(worse, misfits->other);
  if (second < parameters.clearly * best) return std::nullopt;
  return Direction{misfits->left < misfits->right, best,
                   MarginOf(best, parameters.most_shape_misfit, second, parameters.clearly)};
}

std::optional<Direction> DirectionOf(const cv::Mat& shape, const ArrowParameters& parameters) {
  const auto direction = ByProfile(shape, parameters);
  return direction || !parameters.other_shapes ? direction : ByShape(shape, parameters);
}

// The white shape on a green board, the only large one; in the box of the board. `filled`: all that
// the board's outline encloses.
std::optional<cv::Mat> WhiteOn(const cv::Mat& bgr, const cv::Mat& green, const cv::Mat& filled,
                               const ArrowParameters& parameters) {
  constexpr double kAlone = 4;        // times as large as the next one
  constexpr double kBrighter = 1.2;   // than the green
  constexpr double kLeastFull = 0.8;  // of the rectangle around the board
  const int board_px2 = cv::countNonZero(filled);
  if (board_px2 < kLeastFull * double(filled.total())) return std::nullopt;
  std::vector<Contour> outlines = OutlinesOf(filled & ~green);
  std::sort(outlines.begin(), outlines.end(), [](const Contour& one, const Contour& other) {
    return cv::contourArea(one) > cv::contourArea(other);
  });
  if (outlines.empty()) return std::nullopt;
  const double area_px2 = cv::contourArea(outlines[0]);
  if (area_px2 < parameters.least_area_px2) return std::nullopt;
  if (outlines.size() > 1 && cv::contourArea(outlines[1]) * kAlone > area_px2) return std::nullopt;
  cv::Mat shape = cv::Mat::zeros(filled.size(), CV_8UC1), grey;
  cv::drawContours(shape, outlines, 0, cv::Scalar(255), cv::FILLED);
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  if (cv::mean(grey, shape)[0] < kBrighter * cv::mean(grey, green)[0]) return std::nullopt;
  return shape;
}

std::optional<Arrow> ArrowOf(const cv::Mat& bgr, const cv::Mat& mask, const Contour& outline,
                             const ArrowParameters& parameters) {
  const cv::Rect box = cv::boundingRect(outline);
  const bool is_cut =
      box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
  if (is_cut || !StandsAlone(bgr, mask, box)) return std::nullopt;
  cv::Mat filled = cv::Mat::zeros(box.size(), CV_8UC1);
  cv::drawContours(filled, std::vector<Contour>{outline}, 0, cv::Scalar(255), cv::FILLED,
                   cv::LINE_8, cv::noArray(), 0, -box.tl());
  const cv::Mat green = filled & mask(box);
  auto direction = DirectionOf(green, parameters);
  if (!direction && parameters.other_shapes) {
    if (const auto white = WhiteOn(bgr(box), green, filled, parameters)) {
      direction = DirectionOf(*white, parameters);
    }
  }
  if (!direction) return std::nullopt;
  return Arrow{box, direction->left, direction->misfit, direction->margin};
}

}  // namespace

ArrowsFound FindArrows(const cv::Mat& bgr, const ArrowParameters& parameters) {
  CheckCoursePicture(bgr);
  const cv::Rect region = RectOf(parameters.region, bgr.size());
  cv::Mat mask = MaskOf(bgr(region), parameters.green);
  CleanMask(mask, parameters.kernel_px, parameters.kernel_px);
  ArrowsFound found;
  for (const Contour& outline : OutlinesOf(mask)) {
    if (cv::contourArea(outline) < parameters.least_area_px2) continue;
    if (auto arrow = ArrowOf(bgr(region), mask, outline, parameters)) {
      arrow->box += region.tl();
      found.arrows.push_back(*arrow);
    }
  }
  std::stable_sort(
      found.arrows.begin(), found.arrows.end(),
      [](const Arrow& one, const Arrow& other) { return one.box.area() > other.box.area(); });
  if (found.arrows.empty()) return found;
  const bool left = found.arrows.front().left;
  const bool agree = std::all_of(found.arrows.begin(), found.arrows.end(),
                                 [&](const Arrow& arrow) { return arrow.left == left; });
  if (agree) found.direction = left ? "left" : "right";
  return found;
}

}  // namespace musher::vision
