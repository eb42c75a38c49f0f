#include "musher/modules/vision/course/arrow_shapes.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace musher::vision {
namespace {

constexpr int kSide = 24;  // of a silhouette
using Polygon = std::vector<cv::Point2d>;

// CV_32F, 0 to 1, filled to its edges.
cv::Mat Scaled(const cv::Mat& silhouette) {
  cv::Mat scaled;
  silhouette.convertTo(scaled, CV_32F, 1 / 255.0);
  cv::resize(scaled, scaled, {kSide, kSide}, 0, 0, cv::INTER_AREA);
  return scaled;
}

constexpr int kFinePx = 240;

cv::Mat Silhouette(const std::vector<Polygon>& parts) {
  cv::Mat fine = cv::Mat::zeros(kFinePx, kFinePx, CV_8UC1);
  for (const Polygon& part : parts) {
    std::vector<cv::Point> pixels;
    for (const cv::Point2d& corner : part) {
      pixels.emplace_back(cvRound(corner.x * (kFinePx - 1)), cvRound(corner.y * (kFinePx - 1)));
    }
    cv::fillPoly(fine, std::vector{pixels}, 255);
  }
  return Scaled(fine);
}

// With a shaft that is `tail` high at its end and `neck` high at the head.
Polygon Straight(double head, double tail, double neck) {
  const double at = 1 - head;
  return {{0, .5 - tail / 2},  {at, .5 - neck / 2}, {at, 0}, {1, .5}, {at, 1},
          {at, .5 + neck / 2}, {0, .5 + tail / 2}};
}

// Two strokes that are `thick` wide.
Polygon Chevron(double thick) {
  return {{0, 0}, {thick, 0}, {1, .5}, {thick, 1}, {0, 1}, {1 - thick, .5}};
}

// A head `high` high from `neck` on, and shafts `up` and `along` thick.
Polygon Elbow(double high, double neck, double up, double along) {
  const double top = (high - along) / 2, bottom = (high + along) / 2;
  return {{0, 1},       {0, top},       {neck, top},  {neck, 0}, {1, high / 2},
          {neck, high}, {neck, bottom}, {up, bottom}, {up, 1}};
}

std::vector<cv::Mat> ToTheRight() {
  std::vector<cv::Mat> shapes;
  const auto add = [&](const Polygon& corners) { shapes.push_back(Silhouette({corners})); };
  for (const double head : {0.3, 0.4, 0.5, 0.62}) {
    for (const double neck : {0.25, 0.4, 0.55}) {
      add(Straight(head, neck, neck));
      add(Straight(head, neck / 3, neck));
    }
  }
  for (const double thick : {0.25, 0.35, 0.45, 0.55, 0.65}) add(Chevron(thick));
  for (const double high : {0.5, 0.62, 0.75}) {
    for (const double neck : {0.45, 0.58, 0.7}) {
      for (const double up : {0.18, 0.27, 0.36}) {
        for (const double along : {0.15, 0.24}) add(Elbow(high, neck, up, along));
      }
    }
  }
  return shapes;
}

cv::Mat TurnedBy(const cv::Mat& shape, cv::RotateFlags turn) {
  cv::Mat turned;
  cv::rotate(shape, turned, turn);
  return turned;
}

std::vector<cv::Mat> Others() {
  std::vector<cv::Mat> shapes;
  for (const double head : {0.3, 0.45, 0.6}) {
    for (const double neck : {0.25, 0.4, 0.55}) {
      const cv::Mat right = Silhouette({Straight(head, neck, neck)});
      shapes.push_back(TurnedBy(right, cv::ROTATE_90_CLOCKWISE));
      shapes.push_back(TurnedBy(right, cv::ROTATE_90_COUNTERCLOCKWISE));
      if (head > 0.5) continue;
      const double low = .5 - neck / 2, high = .5 + neck / 2;
      shapes.push_back(Silhouette({{{0, .5},
                                    {head, 0},
                                    {head, low},
                                    {1 - head, low},
                                    {1 - head, 0},
                                    {1, .5},
                                    {1 - head, 1},
                                    {1 - head, high},
                                    {head, high},
                                    {head, 1}}}));
    }
  }
  for (const double thick : {0.25, 0.45, 0.65}) {
    const cv::Mat right = Silhouette({Chevron(thick)});
    shapes.push_back(TurnedBy(right, cv::ROTATE_90_CLOCKWISE));
    shapes.push_back(TurnedBy(right, cv::ROTATE_90_COUNTERCLOCKWISE));
  }
  shapes.push_back(Silhouette({{{0, 0}, {1, 0}, {1, 1}, {0, 1}}}));
  shapes.push_back(Silhouette({{{.5, 0}, {1, .5}, {.5, 1}, {0, .5}}}));
  for (const double thick : {0.2, 0.35, 0.5}) {  // crosses, corners
    const double low = .5 - thick / 2, high = .5 + thick / 2;
    const Polygon level{{0, low}, {1, low}, {1, high}, {0, high}};
    const Polygon upright{{low, 0}, {high, 0}, {high, 1}, {low, 1}};
    shapes.push_back(Silhouette({level, upright}));
    const cv::Mat corner =
        Silhouette({{{0, 0}, {1, 0}, {1, thick}, {thick, thick}, {thick, 1}, {0, 1}}});
    for (const auto turn :
         {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180, cv::ROTATE_90_COUNTERCLOCKWISE}) {
      shapes.push_back(TurnedBy(corner, turn));
    }
    shapes.push_back(corner);
  }
  cv::Mat disc = cv::Mat::zeros(kFinePx, kFinePx, CV_8UC1);
  cv::circle(disc, {kFinePx / 2, kFinePx / 2}, kFinePx / 2, 255, cv::FILLED);
  shapes.push_back(Scaled(disc));
  return shapes;
}

// The share of what only one of them covers.
double Misfit(const cv::Mat& one, const cv::Mat& other) {
  double common = 0, all = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const float a = one.at<float>(i / kSide, i % kSide), b = other.at<float>(i / kSide, i % kSide);
    common += double(std::min(a, b));
    all += double(std::max(a, b));
  }
  return all == 0 ? 1 : 1 - common / all;
}

double BestOf(const cv::Mat& shape, const std::vector<cv::Mat>& known) {
  double best = 1;
  for (const cv::Mat& each : known) best = std::min(best, Misfit(shape, each));
  return best;
}

}  // namespace

std::optional<ShapeMisfits> CompareShapes(const cv::Mat& silhouette) {
  static const std::vector<cv::Mat> right = ToTheRight(), others = Others();
  const cv::Rect box = cv::boundingRect(silhouette);
  if (box.empty()) return std::nullopt;
  const cv::Mat shape = Scaled(silhouette(box));
  cv::Mat mirrored;
  cv::flip(shape, mirrored, 1);
  return ShapeMisfits{BestOf(mirrored, right), BestOf(shape, right), BestOf(shape, others)};
}

}  // namespace musher::vision
