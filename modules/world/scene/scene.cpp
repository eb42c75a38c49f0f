#include "musher/modules/world/scene/scene.hpp"

#include <cmath>

namespace musher::world {

CameraSet::CameraSet() {
  auto& [front, left, right] = cameras;
  front.position_m = {0.27, 0, 0.06};
  front.hfov_rad = 2 * std::atan(320.0 / 600);  // a focal length of 600 px
  left.model = CameraModel::kFisheye;
  left.position_m = {0.22, 0.06, 0.05};
  left.yaw_rad = M_PI / 2;
  left.pitch_rad = 20 * M_PI / 180;
  left.hfov_rad = M_PI;
  left.vignette = 0.3;
  right = left;
  right.position_m.y() = -left.position_m.y();
  right.yaw_rad = -left.yaw_rad;
}

}  // namespace musher::world
