#pragma once
// Where rays end in a scenery, and which colour they see.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "musher/modules/world/render/bundle.hpp"
#include "musher/modules/world/render/scenery.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// Traces rays from one position, for one picture.
class Tracer {
 public:
  using Indices = std::vector<std::uint16_t>;  // of things

  // `things` are all that can be seen, and outlive it. The body casts a shadow; its trunk is
  // `trunk_m` over the ground. `pixel_rad` is the angle of a pixel; it determines how much of a
  // surface a pixel covers.
  Tracer(const Scenery& scenery, const std::vector<Thing>& things,
         const Eigen::Isometry3d& camera_in_place, const Pose2& body, double trunk_m,
         double pixel_rad);

  // Sees these things and all behind them.
  void Look(const Rays& rays, const Indices& things, Sights& sights) const;

  const std::vector<Thing>& things() const { return things_; }
  // Of the camera's frame in the place's.
  const Eigen::Matrix3f& turn() const { return turn_; }
  const Eigen::Vector3f& from_m() const { return from_m_; }

 private:
  // What the rays of a bundle meet, in the place's frame.
  struct Paths {
    Each<float> x, y, z;
    Each<float> far_m;                         // to the surface
    Each<std::int32_t> column, row, halvings;  // in the ground's texture
    Each<float> light;                         // share of the light at the ground
  };
  struct Hit {
    float far_m = 0;
    int face = 0;
  };

  void Turn(const Rays& rays, Paths& paths) const;
  void FindBackground(Paths& paths, Sights& sights) const;
  void FindGround(const Rays& rays, Paths& paths) const;
  void ShadowOfBody(Paths& paths) const;
  void ColorSky(const Paths& paths, Sights& sights) const;
  void ColorGround(const Paths& paths, Sights& sights) const;
  void ColorBackground(const Paths& paths, Sights& sights) const;
  void ColorFence(const Paths& paths, std::uint16_t surface, Sights& sights) const;
  Light3 FarGround(float far_m) const;
  void FindThing(std::size_t index, Paths& paths, Sights& sights) const;
  void FindEllipsoid(std::size_t index, Paths& paths, Sights& sights) const;
  Light3 LightOfEllipsoid(const Thing& thing, const Eigen::Vector3f& on_unit,
                          const Eigen::Vector3f& where, float far_m) const;
  Light3 LightOf(const Thing& thing, const Eigen::Vector3f& from, const Eigen::Vector3f& ray,
                 const Hit& hit) const;
  Light3 LightOfBoard(const Thing& thing, const Eigen::Vector3f& where, float slant,
                      const Hit& hit) const;

  const Scenery& scenery_;
  const std::vector<Thing>& things_;
  Eigen::Matrix3f turn_;
  Eigen::Vector3f from_m_;
  float pixel_rad_;
  bool fenced_ = false;
  std::vector<Eigen::Vector3f> from_local_;  // as each thing sees it
  Light3 light_on_ground_;
  Light3 fence_light_[4];
  Light3 far_ground_;
  Light3 horizon_;
  Light3 zenith_;
  // The body's shadow: an ellipse.
  Eigen::Vector2f shadow_m_;
  Eigen::Vector2f shadow_half_m_;
  float shadow_cos_ = 1, shadow_sin_ = 0;
};

}  // namespace musher::world
