#include "musher/modules/vision/course/thing_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace musher::vision {
namespace {

constexpr std::size_t kDirections = 48;
constexpr int kNoisePx = 3;
constexpr double kStepPx = 0.5;
constexpr double kLeastEdge = 20;  // of the colour, in levels

using Levels = std::vector<double>;

// What is below that share of the levels.
double QuantileOf(Levels levels, double share) {
  if (levels.empty()) return 0;
  const auto at = std::min(levels.size() - 1, std::size_t(share * double(levels.size())));
  std::nth_element(levels.begin(), levels.begin() + std::ptrdiff_t(at), levels.end());
  return levels[at];
}

double SpreadOf(const Levels& levels, double median) {
  constexpr double kMost = 0.9;
  Levels off;
  for (const double level : levels) off.push_back(std::abs(level - median));
  return QuantileOf(std::move(off), kMost);
}

// Equally far from each other, along the hull.
std::vector<cv::Point2d> PlacesOn(const Contour& outline) {
  Contour hull;
  cv::convexHull(outline, hull);
  const double step = cv::arcLength(hull, true) / double(kDirections);
  std::vector<cv::Point2d> places;
  double next = 0, from = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const cv::Point2d one(hull[i]), other(hull[(i + 1) % hull.size()]);
    const double length = cv::norm(other - one);
    for (; next < from + length && places.size() < kDirections; next += step) {
      places.push_back(one + (other - one) * ((next - from) / length));
    }
    from += length;
  }
  return places;
}

// A thing in shares of the way from its middle to its outline: 0 is its middle, 1 its outline.
class Thing {
 public:
  Thing(const cv::Size& picture, const Contour& outline)
      : inside_({0, 0}, picture), outline_(PlacesOn(outline)) {
    for (const cv::Point2d& place : outline_) middle_ += place / double(outline_.size());
  }

  std::size_t directions() const { return outline_.size(); }
  double RadiusPx(std::size_t i) const { return cv::norm(outline_[i] - middle_); }
  bool Has(std::size_t i, double share) const { return inside_.contains(At(i, share)); }
  cv::Vec3d Of(const cv::Mat& picture, std::size_t i, double share) const {
    return cv::Vec3d(picture.at<cv::Vec3b>(At(i, share)));
  }
  // Of the colour, outwards; 0 at the picture's edge.
  double Change(const cv::Mat& picture, std::size_t i, double share) const {
    constexpr double kHalfPx = 1.5;
    const double half = kHalfPx / std::max(1.0, RadiusPx(i));
    if (!Has(i, share - half) || !Has(i, share + half)) return 0;
    return cv::norm(Of(picture, i, share - half) - Of(picture, i, share + half));
  }

 private:
  cv::Point At(std::size_t i, double share) const {
    const cv::Point2d at = middle_ + (outline_[i] - middle_) * share;
    return {cvRound(at.x), cvRound(at.y)};
  }

  const cv::Rect inside_;
  const std::vector<cv::Point2d> outline_;
  cv::Point2d middle_{0, 0};
};

struct Edge {
  double on = 0, within = 0;  // the largest change of the colour
};

Edge EdgeOf(const cv::Mat& soft, const Thing& thing, std::size_t i) {
  constexpr double kOffPx = 2.5, kOff = 0.06, kFrom = 0.3;
  const double radius_px = std::max(1.0, thing.RadiusPx(i));
  const double off = std::max(kOffPx / radius_px, kOff);
  Edge edge;
  for (double share = kFrom; share <= 1 + off; share += kStepPx / radius_px) {
    double& most = share < 1 - off ? edge.within : edge.on;
    most = std::max(most, thing.Change(soft, i, share));
  }
  return edge;
}

double MedianAt(const cv::Mat& soft, const Thing& thing, double share, int channel) {
  Levels levels;
  for (std::size_t i = 0; i < thing.directions(); ++i) {
    if (thing.Has(i, share)) levels.push_back(thing.Of(soft, i, share)[channel]);
  }
  return QuantileOf(std::move(levels), 0.5);
}

double RingShare(const cv::Mat& soft, const Thing& thing) {
  constexpr std::array kRings{0.15, 0.3, 0.45, 0.6, 0.72, 0.84};
  constexpr double kLeast = 0.1, kMost = 0.9;  // of the directions: some may be covered
  constexpr double kAround = 1.2;
  double spread = 0, range = 1;
  for (int channel = 0; channel < 3; ++channel) {
    const double around = MedianAt(soft, thing, kAround, channel);
    range = std::max(range, std::abs(MedianAt(soft, thing, kRings.front(), channel) - around));
    for (const double ring : kRings) {
      Levels levels;
      for (std::size_t i = 0; i < thing.directions(); ++i) {
        if (thing.Has(i, ring)) levels.push_back(thing.Of(soft, i, ring)[channel]);
      }
      spread = std::max(spread, QuantileOf(levels, kMost) - QuantileOf(levels, kLeast));
    }
  }
  return spread / range;
}

// The part of the picture with the thing and what is around it, with little noise; the rest is not
// filled.
cv::Mat SoftAround(const cv::Mat& bgr, const cv::Rect& box, double reach) {
  const int rim_px = 6 + int(reach * std::max(box.width, box.height) / 2);
  const cv::Rect wide(box.x - rim_px, box.y - rim_px, box.width + 2 * rim_px,
                      box.height + 2 * rim_px);
  const cv::Rect around = wide & cv::Rect({0, 0}, bgr.size());
  cv::Mat soft(bgr.size(), CV_8UC3);
  cv::GaussianBlur(bgr(around), soft(around), {kNoisePx, kNoisePx}, 0);
  return soft;
}

// How far away from the middle the sharpest edge around the box is in each direction, in shares of
// the box; 0: there is none. An edge at the box that is sharp enough is that of the thing: others
// are behind it.
Levels EdgesAround(const cv::Mat& bgr, const cv::Rect& box) {
  constexpr double kFrom = 0.8, kAtBox = 1.1, kTo = 1.6, kSharp = 100;
  const Thing thing(bgr.size(), EllipseIn(box));
  const cv::Mat soft = SoftAround(bgr, box, kTo);
  Levels edges;
  for (std::size_t i = 0; i < thing.directions(); ++i) {
    double most = kLeastEdge, at = 0;
    for (double share = kFrom; share <= kTo; share += kStepPx / std::max(1.0, thing.RadiusPx(i))) {
      if (share > kAtBox && most > kSharp) break;
      const double change = thing.Change(soft, i, share);
      if (change <= most) continue;
      most = change;
      at = share;
    }
    edges.push_back(at);
  }
  return edges;
}

}  // namespace

Surface SurfaceOf(const cv::Mat& bgr, const Contour& outline) {
  constexpr double kInner = 0.8, kStep = 0.1, kReach = 0.3;
  Surface surface;
  const Thing thing(bgr.size(), outline);
  if (thing.directions() == 0) return surface;
  const cv::Mat soft = SoftAround(bgr, cv::boundingRect(outline), kReach);
  std::vector<cv::Vec3b> colors;
  int edges = 0, ends = 0;
  for (std::size_t i = 0; i < thing.directions(); ++i) {
    const Edge edge = EdgeOf(soft, thing, i);
    edges += edge.on > kLeastEdge ? 1 : 0;
    ends += edge.on > kLeastEdge && edge.on > edge.within ? 1 : 0;
    for (double share = kStep / 2; share < kInner; share += kStep) {
      if (thing.Has(i, share)) colors.emplace_back(thing.Of(soft, i, share));
    }
  }
  cv::Mat hsv;
  if (!colors.empty()) cv::cvtColor(cv::Mat(colors).reshape(3, 1), hsv, cv::COLOR_BGR2HSV);
  Levels hues, saturations;
  for (const cv::Vec3b& color : cv::Mat_<cv::Vec3b>(hsv)) {
    hues.push_back(color[0]);
    saturations.push_back(color[1]);
  }
  surface.edge_share = edges / double(thing.directions());
  surface.end_share = ends / double(thing.directions());
  surface.saturation = QuantileOf(saturations, 0.5);
  surface.hue_spread = SpreadOf(hues, QuantileOf(hues, 0.5));
  surface.saturation_spread = SpreadOf(saturations, surface.saturation);
  surface.ring_share = RingShare(soft, thing);
  constexpr double kMiddle = 0.15, kRim = 0.72, kNoise = 8;
  double brighter = 0;
  for (int channel = 0; channel < 3; ++channel) {
    brighter += MedianAt(soft, thing, kMiddle, channel) - MedianAt(soft, thing, kRim, channel);
  }
  surface.is_darker_inside = brighter < -3 * kNoise;
  return surface;
}

std::optional<cv::Rect> UpToItsEdge(const cv::Mat& bgr, const cv::Rect& box) {
  constexpr double kLeastLarger = 1.06, kAlike = 0.08, kAlikePx = 4, kLeastAlike = 0.7;
  constexpr int kTimes = 2;
  cv::Rect grown = box;
  for (int time = 0; time < kTimes; ++time) {
    const Levels edges = EdgesAround(bgr, grown);
    const double median = QuantileOf(edges, 0.5);
    if (median < kLeastLarger) return grown;
    const double alike = std::max(kAlike, kAlikePx / std::max(1, grown.width));
    const auto count =
        std::ranges::count_if(edges, [&](double edge) { return std::abs(edge - median) <= alike; });
    if (double(count) < kLeastAlike * double(edges.size())) return std::nullopt;
    const cv::Size size(cvRound(median * grown.width), cvRound(median * grown.height));
    grown = {grown.tl() + cv::Point(grown.size() - size) / 2, size};
  }
  return grown;
}

Contour EllipseIn(const cv::Rect& box) {
  Contour outline;
  for (std::size_t i = 0; i < kDirections; ++i) {
    const double turn = 2 * M_PI * double(i) / double(kDirections);
    outline.emplace_back(cvRound(box.x + (box.width - 1) / 2.0 * (1 + std::cos(turn))),
                         cvRound(box.y + (box.height - 1) / 2.0 * (1 + std::sin(turn))));
  }
  return outline;
}

}  // namespace musher::vision
