#include "musher/modules/vision/course/barrier_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "musher/modules/vision/course/bar_stripes.hpp"
#include "musher/modules/vision/course/floor_color.hpp"

namespace musher::vision {
namespace {

struct Bar {
  double length_px = 0;
  double height_px = 0;
  double tilt_deg = 0;  // from level
};

// Of the rectangle around it. OpenCV's corners are the middles of pixels: both sides are one pixel
// longer.
Bar BarOf(const Contour& outline) {
  const cv::RotatedRect around = cv::minAreaRect(outline);
  Bar bar{around.size.width + 1.0, around.size.height + 1.0, around.angle};
  if (bar.length_px < bar.height_px) {
    std::swap(bar.length_px, bar.height_px);
    bar.tilt_deg += 90;
  }
  bar.tilt_deg = std::abs(std::remainder(bar.tilt_deg, 180));
  return bar;
}

// The red pixels that the outline encloses, in the box around it.
cv::Mat Inside(const cv::Mat& mask, const Contour& outline, const cv::Rect& box) {
  cv::Mat inside = cv::Mat::zeros(box.size(), CV_8UC1);
  cv::drawContours(inside, std::vector<Contour>{outline}, 0, cv::Scalar(255), cv::FILLED,
                   cv::LINE_8, cv::noArray(), 0, -box.tl());
  return inside & mask(box);
}

struct TopRun {
  int top = 0, length = 0;
};

// The bar of a gate: in each column what is uppermost, as thick as in most columns. Nothing when
// no columns are clearly thicker, which are the posts.
std::optional<Contour> WithoutPosts(const cv::Mat& inside, const cv::Point& corner) {
  std::vector<TopRun> runs;
  std::vector<int> lengths;
  for (int x = 0; x < inside.cols; ++x) {
    TopRun run;
    while (run.top < inside.rows && inside.at<std::uint8_t>(run.top, x) == 0) ++run.top;
    int y = run.top;
    while (y < inside.rows && inside.at<std::uint8_t>(y, x) != 0) ++y;
    run.length = y - run.top;
    runs.push_back(run);
    lengths.push_back(run.length);
  }
  const auto middle = lengths.begin() + std::ptrdiff_t(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  const int usual = *middle;
  constexpr double kPost = 2, kClip = 1.15;
  const bool has_posts = std::any_of(runs.begin(), runs.end(),
                                     [&](const TopRun& run) { return run.length > kPost * usual; });
  if (usual == 0 || !has_posts) return std::nullopt;
  cv::Mat bar = cv::Mat::zeros(inside.size(), CV_8UC1);
  for (int x = 0; x < inside.cols; ++x) {
    const TopRun& run = runs[std::size_t(x)];
    const int length = std::min(run.length, int(std::ceil(kClip * usual)));
    bar(cv::Rect(x, run.top, 1, length)).setTo(255);
  }
  Contour largest;
  for (Contour& outline : OutlinesOf(bar)) {
    if (outline.size() > largest.size()) largest = outline;
  }
  for (cv::Point& point : largest) point += corner;
  return largest;
}

bool HasShape(const Bar& bar, double area_px2, const BarrierParameters& parameters) {
  return area_px2 >= parameters.least_area_px2 &&
         bar.length_px >= parameters.least_length * bar.height_px &&
         area_px2 >= parameters.least_fill * bar.length_px * bar.height_px &&
         bar.tilt_deg <= parameters.most_tilt_deg;
}

double MarginOf(double length_px, double height_px, double tilt_deg,
                const BarrierParameters& parameters) {
  // Beyond so many least lengths a longer one is no better.
  constexpr double kLong = 3;
  const double length = length_px / (parameters.least_length * std::max(1.0, height_px));
  const double tilt = parameters.most_tilt_deg > 0 ? 1 - tilt_deg / parameters.most_tilt_deg : 1;
  return std::min((length - 1) / (kLong - 1), tilt);
}

// Whether it is no part of something larger: two heights above and below it there is little red. A
// stripe of a flag or of an awning has the next one there.
bool StandsAlone(const cv::Mat& mask, const Contour& outline, double height_px) {
  constexpr double kMostRed = 0.25;
  std::array<cv::Point2f, 4> corners;
  const cv::RotatedRect around = cv::minAreaRect(outline);
  around.points(corners.data());
  // The longer sides, in their middle: from one shorter side to the other one.
  const bool first_is_longer =
      cv::norm(corners[0] - corners[1]) > cv::norm(corners[1] - corners[2]);
  const std::size_t i = first_is_longer ? 1 : 0;
  const cv::Point2d from = cv::Point2d(corners.at(i) + corners.at(i + 1)) / 2;
  const cv::Point2d to = cv::Point2d(corners.at((i + 2) % 4) + corners.at((i + 3) % 4)) / 2;
  const double half_px = std::min(around.size.width, around.size.height) / 2;
  for (const double beyond : {0.5, 1.0, 1.5, 2.0}) {
    const double aside_px = half_px + std::max(3.0, beyond * height_px);
    if (ShareAlong(mask, from, to, aside_px) >= kMostRed ||
        ShareAlong(mask, from, to, -aside_px) >= kMostRed) {
      return false;
    }
  }
  return true;
}

// Whether it is painted, as far as it is large enough to see that: bricks have joints.
bool IsPlain(const cv::Mat& hsv, const cv::Mat& inside, const cv::Rect& box) {
  constexpr int kEdgePx = 9, kAroundPx = 15;
  constexpr double kDifference = 0.08, kMostShare = 0.2;
  constexpr int kLeast = 400;  // pixels
  cv::Mat inner;
  cv::erode(inside, inner, cv::getStructuringElement(cv::MORPH_RECT, {kEdgePx, kEdgePx}), {-1, -1},
            1, cv::BORDER_CONSTANT, cv::Scalar(0));
  const int count = cv::countNonZero(inner);
  if (count < kLeast) return true;
  cv::Mat value, red, smooth, around, share, difference;
  cv::extractChannel(hsv(box), value, 2);
  value.convertTo(value, CV_32F);
  inside.convertTo(red, CV_32F, 1 / 255.0);
  // The mean around each pixel of what is red: the letters of a banner are not.
  cv::blur(value.mul(red), around, {kAroundPx, kAroundPx});
  cv::blur(red, share, {kAroundPx, kAroundPx});
  cv::divide(around, cv::max(share, 1e-3), around);
  cv::blur(value, smooth, {3, 3});
  cv::absdiff(smooth, around, difference);
  cv::Mat uneven = difference > kDifference * cv::mean(value, inner)[0];
  return cv::countNonZero(uneven & inner) < kMostShare * count;
}

// Whether a bar would be cut so: one that is near is wide.
bool MayBeCut(const cv::Rect& box, const cv::Size& picture) {
  constexpr double kLeastWide = 0.5, kMostHigh = 0.25;
  return box.width >= kLeastWide * picture.width && box.height <= kMostHigh * picture.height;
}

std::optional<Barrier> BarrierOf(const cv::Mat& hsv, const cv::Mat& mask, Contour outline,
                                 const BarrierParameters& parameters) {
  if (cv::contourArea(outline) < parameters.least_area_px2 / 2) return std::nullopt;
  Bar bar = BarOf(outline);
  Barrier barrier;
  barrier.box = cv::boundingRect(outline);
  cv::Mat inside = Inside(mask, outline, barrier.box);
  double area_px2 = cv::countNonZero(inside);
  if (!HasShape(bar, area_px2, parameters)) {
    const auto of_gate = WithoutPosts(inside, barrier.box.tl());
    if (!of_gate) return std::nullopt;
    outline = *of_gate;
    bar = BarOf(outline);
    barrier.box = cv::boundingRect(outline);
    inside = Inside(mask, outline, barrier.box);
    area_px2 = cv::countNonZero(inside);
    if (!HasShape(bar, area_px2, parameters)) return std::nullopt;
  }
  barrier.height_px = area_px2 / bar.length_px;
  barrier.cut = barrier.box.y == 0 || barrier.box.br().y == mask.rows;
  if (barrier.cut && !MayBeCut(barrier.box, mask.size())) return std::nullopt;
  if (!barrier.cut) {
    const double fill = barrier.height_px / std::max(1.0, bar.height_px);
    const double fill_margin =
        (fill - parameters.least_fill) / std::max(0.01, 1 - parameters.least_fill);
    barrier.margin =
        std::min(MarginOf(bar.length_px, bar.height_px, bar.tilt_deg, parameters), fill_margin);
  }
  if (!StandsAlone(mask, outline, barrier.height_px)) return std::nullopt;
  return IsPlain(hsv, inside, barrier.box) ? std::optional(barrier) : std::nullopt;
}

void AddStriped(const cv::Mat& hsv, const cv::Mat& mask, Gaps gaps,
                const BarrierParameters& parameters, std::vector<Barrier>& barriers) {
  for (const StripedBar& bar : FindStripedBars(hsv, mask, gaps)) {
    if (bar.length_px < parameters.least_length * bar.height_px) continue;
    if (bar.tilt_deg > parameters.most_tilt_deg) continue;
    Barrier barrier;
    barrier.box = bar.box;
    barrier.height_px = bar.height_px;
    barrier.cut = bar.box.y == 0 || bar.box.br().y == mask.rows;
    if (!barrier.cut) {
      barrier.margin = MarginOf(bar.length_px, bar.height_px, bar.tilt_deg, parameters);
    }
    if (!barrier.cut || MayBeCut(bar.box, mask.size())) barriers.push_back(barrier);
  }
}

}  // namespace

std::optional<Barrier> FindBarrier(const cv::Mat& bgr, const BarrierParameters& parameters) {
  CheckCoursePicture(bgr);
  const cv::Rect region = RectOf(parameters.region, bgr.size());
  cv::Mat hsv;
  cv::cvtColor(bgr(region), hsv, cv::COLOR_BGR2HSV);
  cv::Mat mask = MaskOfHsv(hsv, parameters.red);
  constexpr double kMostCoverage = 0.25;
  if (cv::countNonZero(mask) > kMostCoverage * double(mask.total())) {
    mask = MaskOfLines(bgr(region), parameters.red, kMostCoverage).mask;
  }
  constexpr int kKernelPx = 3;
  CleanMask(mask, kKernelPx, kKernelPx);
  std::vector<Barrier> barriers;
  for (Contour& outline : OutlinesOf(mask)) {
    const auto barrier = BarrierOf(hsv, mask, std::move(outline), parameters);
    if (barrier) barriers.push_back(*barrier);
  }
  if (parameters.striped) {
    AddStriped(hsv, mask, Gaps::kLight, parameters, barriers);
    cv::Mat yellow = MaskOfHsv(hsv, parameters.yellow);
    CleanMask(yellow, kKernelPx, 1);
    AddStriped(hsv, yellow, Gaps::kDark, parameters, barriers);
  }
  const auto largest = std::max_element(
      barriers.begin(), barriers.end(),
      [](const Barrier& one, const Barrier& other) { return one.box.area() < other.box.area(); });
  if (largest == barriers.end()) return std::nullopt;
  largest->box += region.tl();
  largest->top = largest->box.y < parameters.top * bgr.rows;
  return *largest;
}

}  // namespace musher::vision
