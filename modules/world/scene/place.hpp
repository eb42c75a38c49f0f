#pragma once
// Where a body can be: inside the scene's area and outside its obstacles. A body is a circle.
// Boxes, circles, boards and balls are obstacles, unless they hang above it.

#include <Eigen/Core>
#include <vector>

#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// The distance between the point and the nearest surface, negative inside, and the direction away.
struct Clearance {
  double distance_m = 0;
  Eigen::Vector2d away;  // of length 1
};
Clearance From(const Box& box, const Eigen::Vector2d& point_m);
Clearance From(const Circle& circle, const Eigen::Vector2d& point_m);
Clearance From(const Board& board, const Eigen::Vector2d& point_m);
Clearance From(const Ball& ball, const Eigen::Vector2d& point_m);

// Whether the robot's body can stand there.
bool IsFree(const Scene& scene, const Eigen::Vector2d& point_m);
// The same for another body.
bool IsFree(const Scene& scene, const Eigen::Vector2d& point_m, double radius_m, double height_m);

struct Step2 {
  Eigen::Vector2d to_m;
  bool bumped = false;
};
// Where a body gets that is free at `from` and moves a short way to `to`: it slides along
// obstacles, and stays where it cannot.
Step2 Go(const Scene& scene, const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m);

bool IsOnPad(const Scene& scene, const Eigen::Vector2d& point_m);

}  // namespace musher::world
