#include "musher/test/modules/vision/labelled/line_map.hpp"

#include <opencv2/imgproc.hpp>
#include <vector>

namespace musher::vision {

using Eigen::Vector2d;

constexpr double kMapPerM = 200;  // pixels in a metre

LineMap::LineMap(const world::Scene& scene) : least_m_(scene.least_m) {
  const Vector2d size = (scene.most_m - scene.least_m) * kMapPerM;
  cv::Mat ground(static_cast<int>(size.y()), static_cast<int>(size.x()), CV_8UC1, cv::Scalar(255));
  for (const world::Line& line : scene.lines) {
    std::vector<cv::Point> points;
    for (const Vector2d& point : line.points_m) {
      const Vector2d at = (point - least_m_) * kMapPerM;
      points.emplace_back(cvRound(at.x()), cvRound(at.y()));
    }
    cv::polylines(ground, points, false, cv::Scalar(0), cvRound(line.width_m * kMapPerM));
  }
  cv::distanceTransform(ground, gap_px_, cv::DIST_L2, cv::DIST_MASK_PRECISE);
}

bool LineMap::HasLine(const Vector2d& at_m, double margin_m) const {
  const Vector2d at = (at_m - least_m_) * kMapPerM;
  const cv::Point pixel(cvRound(at.x()), cvRound(at.y()));
  if (!cv::Rect({0, 0}, gap_px_.size()).contains(pixel)) return false;
  return gap_px_.at<float>(pixel) <= margin_m * kMapPerM;
}

}  // namespace musher::vision
