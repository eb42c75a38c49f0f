#pragma once
// Pictures for the finders of a course: drawn ones, noise, and scenes of the simulated world.

#include <array>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/shots.hpp"

namespace musher::vision {

const cv::Scalar kGrey(128, 128, 128);
const cv::Scalar kYellow(20, 206, 246);  // blue, green, red
const cv::Scalar kRed(30, 30, 200);
const cv::Scalar kGreen(60, 170, 40);
const cv::Scalar kWhite(245, 245, 245);

inline cv::Mat GreyPicture() {
  return {480, 640, CV_8UC3, kGrey};
}

inline cv::Mat Mirrored(const cv::Mat& bgr) {
  cv::Mat mirrored;
  cv::flip(bgr, mirrored, 1);
  return mirrored;
}

// Each byte of its own.
inline cv::Mat NoisePicture(unsigned seed) {
  cv::Mat noise(480, 640, CV_8UC3);
  cv::RNG random(seed);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  return noise;
}

// Coloured spots of about that size.
inline cv::Mat SpottedPicture(unsigned seed, int spot_px) {
  cv::Mat spots(480 / spot_px, 640 / spot_px, CV_8UC3), picture;
  cv::RNG random(seed);
  random.fill(spots, cv::RNG::UNIFORM, 0, 256);
  cv::resize(spots, picture, {640, 480}, 0, 0, cv::INTER_CUBIC);
  return picture;
}

inline cv::Mat MatOf(const world::Image& image) {
  cv::Mat bgr(image.height, image.width, CV_8UC3);
  std::copy(image.bgr.begin(), image.bgr.end(), bgr.data);
  return bgr;
}

enum class CourseCamera { kFront = 0, kLeft = 1, kRight = 2 };

// With the camera's noise; the robot stands at that pose.
inline cv::Mat SceneShot(const world::Scenery& scenery, CourseCamera camera,
                         const world::Pose2& robot = {}) {
  static const std::array<world::Camera, 3> cameras{world::Camera(world::CameraSet().cameras[0]),
                                                    world::Camera(world::CameraSet().cameras[1]),
                                                    world::Camera(world::CameraSet().cameras[2])};
  world::View view = world::Standing();
  view.body = robot;
  view.seed = 3;
  return MatOf(cameras.at(std::size_t(camera)).Shoot(scenery, view));
}
inline cv::Mat SceneShot(const world::Scene& scene, CourseCamera camera,
                         const world::Pose2& robot = {}) {
  return SceneShot(*world::SceneryOf(scene), camera, robot);
}

inline world::Scene HallScene() {
  world::Scene scene = world::EmptyYard();
  scene.ground.finest_per_m = 100;
  return scene;
}

// Where the front camera is when the robot stands at (0, 0).
inline constexpr double kEyeM = 0.27;
inline constexpr double kEyeHeightM = 0.35;

// A board at that distance from the front camera, its middle `up_m` over it, turned by `yaw_deg`.
inline world::Board BoardAt(double far_m, double size_m, double yaw_deg = 0, double up_m = 0) {
  world::Board board;
  board.center_m = {kEyeM + far_m, 0};
  board.yaw_rad = M_PI + yaw_deg * M_PI / 180;
  board.width_m = board.height_m = size_m;
  board.bottom_m = kEyeHeightM + up_m - size_m / 2;
  return board;
}

// The corners of an arrow that points to the right, in a box of 1 by 1: a shaft `shaft` high, and a
// head of length `head`.
inline std::vector<cv::Point> ArrowCorners(const cv::Rect& box, double head, double shaft) {
  const double top = (1 - shaft) / 2, neck = 1 - head;
  std::vector<cv::Point> corners;
  for (const auto& [x, y] :
       {std::pair(0.0, top), std::pair(neck, top), std::pair(neck, 0.0), std::pair(1.0, 0.5),
        std::pair(neck, 1.0), std::pair(neck, 1 - top), std::pair(0.0, 1 - top)}) {
    corners.emplace_back(box.x + cvRound(x * box.width), box.y + cvRound(y * box.height));
  }
  return corners;
}

inline void DrawArrow(cv::Mat& bgr, const cv::Rect& box, double head = 0.4, double shaft = 0.4) {
  cv::fillPoly(bgr, std::vector{ArrowCorners(box, head, shaft)}, kGreen, cv::LINE_AA);
}

}  // namespace musher::vision
