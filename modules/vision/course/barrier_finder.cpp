#include "musher/modules/vision/course/barrier_finder.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

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

std::optional<Barrier> BarrierOf(const cv::Mat& mask, const Contour& outline,
                                 const BarrierParameters& parameters) {
  const Bar bar = BarOf(outline);
  const cv::Rect box = cv::boundingRect(outline);
  const double area_px2 = cv::countNonZero(mask(box));
  if (area_px2 < parameters.least_area_px2) return std::nullopt;
  if (bar.length_px < parameters.least_length * bar.height_px) return std::nullopt;
  if (area_px2 < parameters.least_fill * bar.length_px * bar.height_px) return std::nullopt;
  if (bar.tilt_deg > parameters.most_tilt_deg) return std::nullopt;
  Barrier barrier;
  barrier.box = box;
  barrier.height_px = area_px2 / bar.length_px;
  barrier.cut = box.y == 0 || box.br().y == mask.rows;
  return barrier;
}

}  // namespace

std::optional<Barrier> FindBarrier(const cv::Mat& bgr, const BarrierParameters& parameters) {
  CheckCoursePicture(bgr);
  const cv::Rect region = RectOf(parameters.region, bgr.size());
  cv::Mat mask = MaskOf(bgr(region), parameters.red);
  constexpr int kKernelPx = 3;
  CleanMask(mask, kKernelPx, kKernelPx);
  std::optional<Barrier> largest;
  for (const Contour& outline : OutlinesOf(mask)) {
    const auto barrier = BarrierOf(mask, outline, parameters);
    if (!barrier) continue;
    if (!largest || barrier->box.area() > largest->box.area()) largest = barrier;
  }
  if (!largest) return largest;
  largest->box += region.tl();
  largest->top = largest->box.y < parameters.top * bgr.rows;
  return largest;
}

}  // namespace musher::vision
