#include "musher/modules/vision/course/aruco_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace musher::vision {
namespace {

using Corners = std::vector<cv::Point2f>;

struct Markers {
  std::vector<Corners> corners;
  std::vector<int> numbers;
};

// A number of OpenCV: since 4.7 the type of these names has another name.
int NameOf(ArucoDictionary dictionary) {
  switch (dictionary) {
    case ArucoDictionary::k5x5:
      return cv::aruco::DICT_5X5_50;
    case ArucoDictionary::k6x6:
      return cv::aruco::DICT_6X6_50;
    case ArucoDictionary::kAprilTag16h5:
      return cv::aruco::DICT_APRILTAG_16h5;
    case ArucoDictionary::kAprilTag36h11:
      return cv::aruco::DICT_APRILTAG_36h11;
    case ArucoDictionary::k4x4:
      break;
  }
  return cv::aruco::DICT_4X4_50;
}

Markers MarkersOf(const cv::Mat& bgr, ArucoDictionary dictionary) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  Markers found;
#if CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR >= 407
  const cv::aruco::ArucoDetector detector(cv::aruco::getPredefinedDictionary(NameOf(dictionary)));
  detector.detectMarkers(grey, found.corners, found.numbers);
#else
  cv::aruco::detectMarkers(grey, cv::aruco::getPredefinedDictionary(NameOf(dictionary)),
                           found.corners, found.numbers);
#endif
  return found;
}

// The point of a picture on a plane at the distance 1 before the camera; nothing beside or behind
// it.
std::optional<cv::Point2f> OnPlane(const cv::Point2f& pixel, const cv::Size& picture,
                                   const Lens& lens) {
  const double x = (double(pixel.x) / picture.width - lens.center_x) / lens.focal_x;
  const double y = (double(pixel.y) / picture.height - lens.center_y) / lens.focal_y;
  if (!lens.fisheye) return cv::Point2f(float(x), float(y));
  constexpr double kWidestRad = 1.4;  // beyond it a plane ahead shows nothing
  const double angle = std::hypot(x, y);
  if (angle > kWidestRad) return std::nullopt;
  const double stretch = angle == 0 ? 1 : std::tan(angle) / angle;
  return cv::Point2f(float(x * stretch), float(y * stretch));
}

// NaN where it is not known.
double DistanceM(const Corners& corners, const cv::Size& picture, const Lens& lens, double size_m) {
  Corners seen;
  for (const cv::Point2f& corner : corners) {
    const auto point = OnPlane(corner, picture, lens);
    if (!point) return std::nan("");
    seen.push_back(*point);
  }
  const auto half = static_cast<float>(size_m / 2);
  const std::vector<cv::Point3f> square{
      {-half, half, 0}, {half, half, 0}, {half, -half, 0}, {-half, -half, 0}};
  cv::Vec3d turned, middle;
  const cv::Matx33d none = cv::Matx33d::eye();
  if (!cv::solvePnP(square, seen, none, cv::noArray(), turned, middle, false,
                    cv::SOLVEPNP_IPPE_SQUARE)) {
    return std::nan("");
  }
  return cv::norm(middle);
}

}  // namespace

std::optional<ArucoFound> FindAruco(const cv::Mat& bgr, const ArucoParameters& parameters,
                                    const std::optional<Lens>& lens) {
  CheckCoursePicture(bgr);
  const Markers markers = MarkersOf(bgr, parameters.dictionary);
  if (markers.numbers.empty()) return std::nullopt;
  const auto area = [&](std::size_t i) { return cv::contourArea(markers.corners[i]); };
  const auto word = [&](std::size_t i) {
    const auto number = static_cast<std::size_t>(markers.numbers[i]);
    return number < parameters.words.size() ? parameters.words[number] : std::string();
  };
  std::size_t largest = 0;
  for (std::size_t i = 1; i < markers.numbers.size(); ++i) {
    if (area(i) > area(largest)) largest = i;
  }
  const Corners& corners = markers.corners[largest];
  const double focal = parameters.focal_px / 640;
  const Lens known = lens.value_or(Lens{false, focal, focal * bgr.cols / bgr.rows, 0.5, 0.5});
  ArucoFound found{word(largest), markers.numbers[largest], cv::boundingRect(corners),
                   DistanceM(corners, bgr.size(), known, parameters.size_m)};
  found.margin = 1;
  for (std::size_t i = 0; i < markers.numbers.size(); ++i) {
    if (word(i) == word(largest)) continue;
    if (area(i) >= parameters.nearly * area(largest)) found.word.clear();
    const double nearly_px2 = std::max(1e-6, parameters.nearly * area(largest));
    found.margin = std::min(found.margin, 1 - area(i) / nearly_px2);
  }
  return found;
}

}  // namespace musher::vision
