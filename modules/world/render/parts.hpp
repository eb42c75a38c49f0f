#pragma once
// The rounded parts of people and robots.

#include <Eigen/Geometry>
#include <vector>

#include "musher/modules/world/render/scenery.hpp"

namespace musher::world {

// An ellipsoid in the place; the columns of `turned` are its axes.
Thing Rounded(const Eigen::Vector3d& center_m, const Eigen::Matrix3d& turned,
              const Eigen::Vector3d& half_m, const Light3& color);

// Adds parts by their position in a body's frame: x ahead, y to the left, z up. All sizes are
// multiplied by `times`.
class Parts {
 public:
  // `things` outlive it.
  Parts(const Eigen::Isometry3d& body_in_place, std::vector<Thing>& things, double times = 1)
      : body_in_place_(body_in_place), things_(things), times_(times) {}

  // Turned as the body is, or within it.
  void Round(const Eigen::Vector3d& at_m, const Eigen::Vector3d& half_m, const Light3& color) {
    Round(at_m, Eigen::Matrix3d::Identity(), half_m, color);
  }
  void Round(const Eigen::Vector3d& at_m, const Eigen::Matrix3d& turned,
             const Eigen::Vector3d& half_m, const Light3& color);
  // From a joint to the next.
  void Limb(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m, double radius_m,
            const Light3& color);

 private:
  const Eigen::Isometry3d body_in_place_;
  std::vector<Thing>& things_;
  const double times_;
};

}  // namespace musher::world
