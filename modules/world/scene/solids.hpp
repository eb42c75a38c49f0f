#pragma once
// What a body in a place can bump into: upright prisms and cylinders, each between two heights, and
// the fence around the place. Metres in the place's frame. Pure; any thread.

#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

inline constexpr double kStandingInM = 0.02;  // so deep in a thing, a body still stands on it

// An upright cylinder by the middle of its underside.
struct BodyCylinder {
  Eigen::Vector3d feet_m{0, 0, 0};
  double radius_m = 0;
  double height_m = 0;
};

struct Solid {
  std::string what;  // in messages: box "shelf", jetbot_1
  std::variant<Box, Circle> shape;
};

// The boxes, circles, boards and shown balls of a scene.
std::vector<Solid> SolidsOf(const Scene& scene);

double BottomOf(const Solid& solid);
double TopOf(const Solid& solid);
// As seen from above, negative inside.
double DistanceTo(const Solid& solid, const Eigen::Vector2d& point_m);

// The largest upright cylinder in its middle: things whose cores do not overlap may be side by
// side.
BodyCylinder CoreOf(const Solid& solid);

// Whether a body overlaps it. To touch it is not to overlap.
bool Overlaps(const Solid& solid, const BodyCylinder& body);
// Whether a body that goes there gets into the solid, or deeper into it than it is.
bool Blocks(const Solid& solid, const BodyCylinder& body, const Eigen::Vector3d& to_m);
// The same of the fence around the place, and of its ceiling.
bool FenceBlocks(const Scene& scene, const BodyCylinder& body, const Eigen::Vector3d& to_m);
// Whether the body is wholly within the fence and below the ceiling.
bool IsWithin(const Scene& scene, const BodyCylinder& body);

// The greatest height that a body can stand on, at most its own: the ground is 0.
double FloorBelow(const std::vector<Solid>& solids, const BodyCylinder& body);

}  // namespace musher::world
