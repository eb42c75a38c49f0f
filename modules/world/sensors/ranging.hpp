#pragma once
// The distance to the next thing: rays against what stands in a scene - boxes, walls, cylinders,
// balls and boards up to their heights, the fence around the place, and the ground.

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "musher/modules/world/body/normal_random.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

inline constexpr double kNothing = std::numeric_limits<double>::infinity();

// What rays of at most `most_m` from one point can hit: made once for all rays of a sensor.
class RayTargets {
 public:
  RayTargets(const Scene& scene, const Eigen::Vector3d& from_m, double most_m);

  // The distance to the nearest surface in that direction, which has length 1; kNothing beyond
  // most_m. 0 from inside a thing.
  double DistanceAlong(const Eigen::Vector3d& along) const;

 private:
  // A thing as an upright prism or cylinder, in a frame of its own around it.
  struct Solid {
    Eigen::Vector3d from_m;  // the point in that frame
    double cos_yaw = 1;
    double sin_yaw = 0;
    Eigen::Vector3d least_m;  // of a prism
    Eigen::Vector3d most_m;
    double radius_m = 0;  // of a cylinder, else 0
    bool round = false;   // of a board: the ellipse in it
  };
  struct Round {
    Eigen::Vector3d from_m;  // the point as seen from its centre
    double radius_m = 0;
  };

  void Add(const Eigen::Vector2d& center_m, double yaw_rad, const Eigen::Vector2d& half_m,
           double bottom_m, double height_m, double radius_m, bool round = false);
  // Where a ray meets the plane of a round board.
  static bool IsOnDisc(const Solid& board, double along_y, double along_z, double distance_m);
  double ToFence(const Eigen::Vector3d& along) const;

  Eigen::Vector3d from_m_;
  double most_m_;
  Eigen::Vector2d least_place_m_;
  Eigen::Vector2d most_place_m_;
  double fence_height_m_;
  std::vector<Solid> solids_;
  std::vector<Round> rounds_;
};

// Of the rays of a sensor: noise may bring a reading back within its reach.
inline double RayLength(const Reach& reach) {
  return reach.most_m + 3 * reach.noise_m;
}

// The sensor's reading of a distance.
inline double Reading(const Reach& reach, double distance_m, NormalRandom& random) {
  const double reading_m = distance_m + reach.noise_m * random.Normal();
  if (reading_m < reach.least_m) return -kNothing;
  if (reading_m > reach.most_m) return kNothing;
  return reading_m;
}

// One ray.
double DistanceAlong(const Scene& scene, const Eigen::Vector3d& from_m,
                     const Eigen::Vector3d& along, double most_m);

}  // namespace musher::world
