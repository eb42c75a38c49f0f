#pragma once
// Pictures of scenes, for tests that look at them.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "musher/modules/world/render/render.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::world {

inline View Standing() {
  return {{}, {0.29, 0, 0}};
}

// To be made once for all pictures of a scene: its ground has millions of texels.
inline std::unique_ptr<Scenery> SceneryOf(const Scene& scene) {
  auto scenery = Scenery::Make(scene);
  EXPECT_TRUE(scenery);
  return std::move(scenery).value();
}

inline Image ShotOf(const Scene& scene, const CameraSpec& spec, const View& view) {
  return Camera(spec).Shoot(*SceneryOf(scene), view);
}

inline CameraSpec FrontCamera() {
  CameraSpec spec = CameraSet().cameras[0];
  spec.noise = 0;
  return spec;
}

// From (0, 0), looking along x.
inline Image FrontShot(const Scene& scene) {
  return ShotOf(scene, FrontCamera(), Standing());
}

// Where FrontShot shows a point.
inline Eigen::Vector2i PixelOf(const Eigen::Vector3d& point_m) {
  const auto camera = CameraInPlace(FrontCamera(), {}, Standing().attitude);
  const auto pixel = Project(IntrinsicsOf(FrontCamera()), camera.inverse() * point_m);
  EXPECT_TRUE(pixel);
  return pixel.value_or(Eigen::Vector2d(0, 0)).array().round().cast<int>();
}

// The middle of all pixels of that kind.
inline std::optional<Eigen::Vector2d> MiddleOf(
    const Image& image, const std::function<bool(const std::uint8_t*)>& is_such) {
  Eigen::Vector2d sum(0, 0);
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (!is_such(image.At(x, y))) continue;
      sum += Eigen::Vector2d(x, y);
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

// The middle of a small ball that glows at `center_m`, where the picture shows it.
inline std::optional<Eigen::Vector2d> MiddleOfGlowingBall(Scene scene, const CameraSpec& spec,
                                                          const View& view,
                                                          const Eigen::Vector3d& center_m) {
  Ball ball;
  ball.center_m = center_m;
  ball.radius_m = 0.05;
  ball.color = {255, 0, 255};
  ball.glows = true;
  scene.balls = {ball};
  return MiddleOf(ShotOf(scene, spec, view), [](const std::uint8_t* pixel) {
    return pixel[0] > 200 && pixel[1] < 80 && pixel[2] > 200;
  });
}

inline cv::Mat GreyOf(const Image& image) {
  cv::Mat bgr(image.height, image.width, CV_8UC3);
  std::copy(image.bgr.begin(), image.bgr.end(), bgr.data);
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// A picture with red in the upper left quarter, blue in the upper right one and yellow below.
inline std::string WriteQuarters(const std::string& path) {
  cv::Mat image(200, 200, CV_8UC3, cv::Scalar(20, 206, 246));
  image(cv::Rect(0, 0, 100, 100)).setTo(cv::Scalar(10, 10, 220));
  image(cv::Rect(100, 0, 100, 100)).setTo(cv::Scalar(220, 10, 10));
  EXPECT_TRUE(cv::imwrite(path, image));
  return path;
}

}  // namespace musher::world
