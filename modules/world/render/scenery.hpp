#pragma once
// A scene prepared for drawing: the things that rays can hit, and the painted surfaces.
//
// Threads: immutable; any number of concurrent readers.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/world/paint/texture.hpp"
#include "musher/modules/world/scene/scene.hpp"
#include "musher/modules/world/scene/solids.hpp"
#include "musher/modules/world/simulation/guests.hpp"

namespace musher::world {

struct Figure;  // see figure.hpp

using Light3 = Eigen::Array3f;  // red, green, blue; 255 is white

// A bounding sphere of a part of a thing.
struct Ball3 {
  Eigen::Vector3f center_m;
  float radius_m = 0;
};

// A box, an upright cylinder, a sphere, an upright rectangle, or an ellipsoid turned any way.
struct Thing {
  enum class Shape { kBox, kCylinder, kSphere, kBoard, kEllipsoid };
  Shape shape = Shape::kBox;
  Eigen::Vector3f center_m;
  Eigen::Vector3f half_m;  // a cylinder's and a sphere's radius is x, a board's x is 0
  float cos_yaw = 1, sin_yaw = 0;
  Light3 color;
  // Of an ellipsoid, instead of its yaw: maps its frame to one in which it is the unit sphere.
  Eigen::Matrix3f to_unit = Eigen::Matrix3f::Identity();
  std::shared_ptr<const Texture> front;  // of a board, or of an ellipsoid's half towards its x
  bool glows = false;
  bool round = false;         // of a board: the ellipse in the rectangle
  std::vector<Ball3> bounds;  // all of it is within these
};

class Scenery {
 public:
  // Fails when a picture does not exist any more. Takes some tenths of a second.
  static Result<std::unique_ptr<Scenery>> Make(const Scene& scene);
  ~Scenery();

  // Things that do not move.
  const std::vector<Thing>& things() const { return things_; }
  // These without the hidden balls, by their index in ascending order, and with the guests at their
  // present positions, as the scene lists them.
  std::vector<Thing> With(const std::vector<Guest>& guests,
                          const std::vector<std::size_t>& hidden_balls = {}) const;
  const Texture& ground() const { return ground_; }
  float texels_per_m() const { return texels_per_m_; }
  const Eigen::Vector2f& least_m() const { return least_m_; }
  const Eigen::Vector2f& most_m() const { return most_m_; }
  float fence_height_m() const { return fence_height_m_; }
  const Light3& fence_color() const { return fence_color_; }
  const Light3& sky() const { return sky_; }

  const Eigen::Vector3f& towards_light() const { return towards_light_; }
  bool shadows() const { return shadows_; }
  float light_in_shadow() const { return light_in_shadow_; }
  // The light on a surface with that normal. Light is scattered: surfaces that face away from it
  // still differ.
  Light3 LightOn(const Eigen::Vector3f& normal) const {
    const float half = 0.5F + 0.5F * normal.dot(towards_light_);
    return tint_ * (ambient_ + (1 - ambient_) * half * half);
  }
  // Share of the light at a position.
  float LightAt(float x_m, float y_m) const {
    const float share = dim_from_ - dim_x_ * x_m - dim_y_ * y_m;
    const float most = share < 1 ? share : 1;
    return most > least_light_ ? most : least_light_;
  }
  const Light3& tint() const { return tint_; }

 private:
  Scenery(const Scene& scene, Texture ground);
  void Dim(const Scene& scene);

  std::vector<Thing> things_;
  std::size_t first_ball_ = 0;   // in things_
  std::vector<Figure> figures_;  // of the guests
  Texture ground_;
  float texels_per_m_ = 1;
  Eigen::Vector2f least_m_, most_m_;
  float fence_height_m_ = 0;
  Light3 fence_color_, sky_, tint_;
  Eigen::Vector3f towards_light_;
  float ambient_ = 1;
  bool shadows_ = true;
  float light_in_shadow_ = 1;
  float dim_from_ = 1, dim_x_ = 0, dim_y_ = 0, least_light_ = 0;
};

Thing ThingOf(const Solid& solid);

Light3 ToLight(const Color& color);

// The light of a black body of that temperature relative to 6500 K, at the same brightness.
Light3 TintOf(double temperature_k);

}  // namespace musher::world
