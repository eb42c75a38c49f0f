#pragma once
// Draws what a camera sees: a pure function of the scenery, the camera, the poses and a seed.
//
// Each pixel follows its ray to the nearest surface. A pixel whose neighbours see different
// surfaces is drawn again from four rays. A thing is tested only in the tiles of the picture that
// it may cover.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/render/lens.hpp"
#include "musher/modules/world/render/robot_figure.hpp"
#include "musher/modules/world/render/scenery.hpp"
#include "musher/modules/world/scene/solids.hpp"

namespace musher::world {

// 8 bits of blue, green and red for each pixel, row by row.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> bgr;

  const std::uint8_t* At(int x, int y) const {
    return bgr.data() + 3 * (std::size_t(y) * std::size_t(width) + std::size_t(x));
  }
};

// The variable part of a picture: where the body is, which casts a shadow, where its head looks,
// the guests, the balls that are hidden, the noise, and a humanoid's stance; other bodies are not
// drawn.
struct View {
  Pose2 body;
  Attitude attitude;
  std::uint64_t seed = 0;  // of the noise
  Gaze gaze = {};
  std::vector<Guest> guests = {};              // as the scene lists them
  std::vector<std::size_t> hidden_balls = {};  // in ascending order
  std::optional<HumanoidStance> humanoid = {};
  std::vector<Solid> moving = {};  // robots, movers and objects that the camera may see
};

class Camera {
 public:
  explicit Camera(const CameraSpec& spec);

  const Intrinsics& intrinsics() const { return lens_.intrinsics(); }
  const CameraSpec& spec() const { return spec_; }

  // Threads: any number concurrently.
  Image Shoot(const Scenery& scenery, const View& view) const;

 private:
  void AddNoise(std::uint64_t seed, Image& image) const;

  CameraSpec spec_;
  Lens lens_;
  std::vector<std::int16_t> noise_;  // as long as the longest row and more
};

}  // namespace musher::world
