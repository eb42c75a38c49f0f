#pragma once
// Pictures of a hall that the world's renderer has no part in. The floor and its lines are painted
// from above, things are flat faces, and all of it is seen through cameras whose equations are
// written here once more. Of the world only the places of things, bodies and cameras are used.
//
// Frame: that of the scene, metres. Colours are albedos in linear light, blue first; the light is
// that of a black body, and the cameras have no white balance. The hall has four walls, with doors,
// windows and posters, or a photograph on them. The same seed gives the same picture.
//
// Threads: one at a time.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "musher/modules/world/render/render.hpp"
#include "musher/test/modules/vision/floor_pictures.hpp"
#include "musher/test/modules/vision/thing_pictures.hpp"

namespace musher::race::testing {

struct HallPaint {
  vision::floors::Floor floor;  // its tapes are those of the scene
  cv::Mat wall{};               // CV_32FC3, linear: a photograph on each wall; empty: painted
};

class HallPainter {
 public:
  HallPainter(const world::Scene& scene, const HallPaint& paint);

  // CV_8UC3, what the scene's camera records.
  cv::Mat Taken(std::size_t camera, const world::View& view) const;

 private:
  // From fine to coarse, each half as fine as the one before.
  struct Texture {
    std::vector<cv::Mat> levels;
    double px_per_m = 1;  // of the first
  };

  // A flat face. `right` and `up` lead from its middle to its edges.
  struct Panel {
    Eigen::Vector3d middle, right, up;
    Texture face;        // CV_32FC4: colour times cover, cover
    bool turns = false;  // a post: it always looks at the camera
  };

  struct Eye {
    Eigen::Vector3d at;
    Eigen::Matrix3d turn;  // from the camera's frame, x ahead, y to the left, z up
    const world::CameraSpec* spec = nullptr;
    double px_per_rad = 1;
  };

  // What a picture shows before it is exposed.
  struct Scenery {
    cv::Mat rays;   // CV_32FC3, in the scene's frame, of length 1; 0 beyond the lens's circle
    cv::Mat light;  // CV_32FC3
    cv::Mat far;    // CV_32F, metres along the ray
  };

  void PaintFloor(const world::Scene& scene, const vision::floors::Floor& floor);
  void PaintWalls(const cv::Mat& photograph, std::uint64_t seed);
  void PutBoard(const world::Board& board);
  void PutBox(const world::Box& box);
  void PutPost(const world::Circle& circle);

  Eye EyeOf(std::size_t camera, const world::View& view) const;
  Scenery Empty(std::size_t camera, const Eye& eye) const;
  void Draw(const Panel& panel, const Eye& eye, Scenery& scenery) const;
  void AddLamp(const world::Ball& ball, const Eye& eye, Scenery& scenery, cv::Mat& lamps) const;
  cv::Rect2d BoxOf(const std::vector<Eigen::Vector3d>& points, const Eye& eye) const;
  cv::Mat Exposed(const cv::Mat& light, const cv::Mat& lamps, std::uint64_t seed) const;

  const vision::floors::Light light_;
  const Eigen::Vector2d least_m_, most_m_;
  std::array<world::CameraSpec, world::kCameras> cameras_;
  std::array<cv::Mat, world::kCameras> rays_;  // CV_32FC3, in the camera's frame
  std::vector<world::Ball> balls_;
  std::vector<Panel> panels_;
  Texture floor_, wall_;
  cv::Mat noise_;  // larger than a picture
};

}  // namespace musher::race::testing
