#pragma once
// Draws what a camera sees: a pure function of the scenery, the camera, where they are and a seed.
//
// Each pixel follows its ray to the nearest surface. Where neighbours see different surfaces the
// pixel is drawn again from four rays. Things are looked for only in the tiles of the picture that
// they may be in.

#include <cstdint>
#include <memory>
#include <vector>

#include "musher/modules/world/camera_model.hpp"
#include "musher/modules/world/lens.hpp"
#include "musher/modules/world/scenery.hpp"

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

// Where the body is when the picture is taken, which casts a shadow, where its head looks, who else
// is there, and what chance adds.
struct View {
  Pose2 body;
  Attitude attitude;
  std::uint64_t seed = 0;  // of the noise
  Gaze gaze = {};
  std::vector<Guest> guests = {};  // as the scene lists them
};

class Camera {
 public:
  explicit Camera(const CameraSpec& spec);

  const Intrinsics& intrinsics() const { return lens_.intrinsics(); }
  const CameraSpec& spec() const { return spec_; }

  // Threads: as many as like at once.
  Image Shoot(const Scenery& scenery, const View& view) const;

 private:
  void AddNoise(std::uint64_t seed, Image& image) const;

  CameraSpec spec_;
  Lens lens_;
  std::vector<std::int16_t> noise_;  // as long as the longest row and more
};

}  // namespace musher::world
