#pragma once
// The pictures on the surfaces of a scene, painted once before the cameras are used.
//
// Threads: any; no shared data. Painting a ground takes some tenths of a second.

#include "musher/base/result.hpp"
#include "musher/modules/world/paint/texture.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// The front of a board, its first row uppermost. Fails when its picture does not exist any more.
Result<Texture> PaintSign(const Board& board);

// The front of a head, hair included; its edge is an ellipse.
Result<Texture> PaintHead(int face);

// The ground of the place with all that is painted on it and the shadows on it. Its first row lies
// along least_m.y, its first column along least_m.x.
Result<Texture> PaintGround(const Scene& scene);

// The share of light that remains in a shadow on the ground.
double LightInShadow(const Lighting& light);

// From the ground towards the light.
Eigen::Vector3d TowardsLight(const Lighting& light);

}  // namespace musher::world
