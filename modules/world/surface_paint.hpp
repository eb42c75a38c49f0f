#pragma once
// The pictures on the surfaces of a scene, painted once before the cameras look.
//
// Threads: any; they work on nothing that is shared. Painting a ground takes some tenths of a
// second.

#include "musher/lifecycle/result.hpp"
#include "musher/modules/world/scene.hpp"
#include "musher/modules/world/texture.hpp"

namespace musher::world {

// The front of a board, its first row uppermost. Fails when its picture is not there any more.
Result<Texture> PaintSign(const Board& board);

// What a head shows to those in front of it, hair and all; its edge is an ellipse.
Result<Texture> PaintHead(int face);

// The ground of the place with all that is painted on it and the shadows that fall on it. Its first
// row lies along least_m.y, its first column along least_m.x.
Result<Texture> PaintGround(const Scene& scene);

// What share of its light the ground has in a shadow.
double LightInShadow(const Lighting& light);

// From the ground towards the light.
Eigen::Vector3d TowardsLight(const Lighting& light);

}  // namespace musher::world
