#pragma once
// Where the lines of a scene are painted. Metres in the frame of the place. Threads: immutable.

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "musher/modules/world/scene/scene.hpp"

namespace musher::vision {

// Where the lines of the course are, as a picture of the ground.
class LineMap {
 public:
  explicit LineMap(const world::Scene& scene);
  // Whether a line is within `margin_m` of that place.
  bool HasLine(const Eigen::Vector2d& at_m, double margin_m = 0) const;

 private:
  Eigen::Vector2d least_m_;
  cv::Mat gap_px_;  // from each place to the nearest line
};

}  // namespace musher::vision
