#pragma once
// Where a ray meets a thing. Rays and positions are in the thing's frame: from its middle, turned
// with it. Inline, since it runs for every ray.

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "musher/modules/world/render/scenery.hpp"

namespace musher::world {

inline constexpr float kFar = std::numeric_limits<float>::max();
inline constexpr float kNearest = 1e-3F;  // metres; nearer surfaces are not seen

// Of a thing: x and y are its sides, z is its upper and lower side.
enum Face { kFaceX, kFaceY, kFaceZ, kRound, kFront, kBack };

inline bool MeetsBox(const Eigen::Vector3f& half, const Eigen::Vector3f& from,
                     const Eigen::Vector3f& ray, float& far_m, int& face) {
  float enter = kNearest;
  float leave = kFar;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(ray[axis]) < 1e-9F) {
      if (std::abs(from[axis]) > half[axis]) return false;
      continue;
    }
    const float each = 1 / ray[axis];
    const float reach = half[axis] * std::abs(each);
    const float middle = -from[axis] * each;
    if (middle - reach > enter) {
      enter = middle - reach;
      face = axis;
    }
    leave = std::min(leave, middle + reach);
    if (enter > leave) return false;
  }
  if (enter <= kNearest) return false;  // from inside
  far_m = enter;
  return true;
}

inline bool MeetsSphere(float radius, const Eigen::Vector3f& from, const Eigen::Vector3f& ray,
                        float& far_m) {
  const float middle = -from.dot(ray);
  if (middle <= 0) return false;
  const float aside2 = (from + middle * ray).squaredNorm();  // better rounded than |from|^2 - ...
  const float under = radius * radius - aside2;
  if (under <= 0) return false;
  far_m = middle - std::sqrt(under);
  return far_m > kNearest;
}

inline bool MeetsCylinder(const Eigen::Vector3f& half, const Eigen::Vector3f& from,
                          const Eigen::Vector3f& ray, float& far_m, int& face) {
  float best = kFar;
  const float a = ray.head<2>().squaredNorm();
  if (a > 1e-12F) {
    const float middle = -from.head<2>().dot(ray.head<2>()) / a;
    const float aside2 = (from.head<2>() + middle * ray.head<2>()).squaredNorm();
    const float under = half.x() * half.x() - aside2;
    if (under <= 0) return false;
    const float enter = middle - std::sqrt(under / a);
    if (enter > kNearest && std::abs(from.z() + enter * ray.z()) <= half.z()) {
      best = enter;
      face = kRound;
    }
  }
  const float lid = ray.z() < 0 ? half.z() : -half.z();
  const float to_lid = (lid - from.z()) / ray.z();
  if (to_lid > kNearest && to_lid < best &&
      (from.head<2>() + to_lid * ray.head<2>()).squaredNorm() <= half.x() * half.x()) {
    best = to_lid;
    face = kFaceZ;
  }
  far_m = best;
  return best < kFar;
}

inline bool MeetsBoard(const Eigen::Vector3f& half, bool round, const Eigen::Vector3f& from,
                       const Eigen::Vector3f& ray, float& far_m, int& face) {
  if (std::abs(ray.x()) < 1e-9F) return false;
  const float far = -from.x() / ray.x();
  if (far <= kNearest) return false;
  const float aside = (from.y() + far * ray.y()) / half.y();
  const float up = (from.z() + far * ray.z()) / half.z();
  if (round ? aside * aside + up * up > 1 : std::abs(aside) > 1 || std::abs(up) > 1) return false;
  far_m = far;
  face = ray.x() < 0 ? kFront : kBack;
  return true;
}

// From `from` along `ray`, both in the thing's frame.
inline bool Meets(const Thing& thing, const Eigen::Vector3f& from, const Eigen::Vector3f& ray,
                  float& far_m, int& face) {
  switch (thing.shape) {
    case Thing::Shape::kBox:
      return MeetsBox(thing.half_m, from, ray, far_m, face);
    case Thing::Shape::kCylinder:
      return MeetsCylinder(thing.half_m, from, ray, far_m, face);
    case Thing::Shape::kSphere:
      face = kRound;
      return MeetsSphere(thing.half_m.x(), from, ray, far_m);
    case Thing::Shape::kBoard:
      return MeetsBoard(thing.half_m, thing.round, from, ray, far_m, face);
    case Thing::Shape::kEllipsoid:  // Tracer's
      break;
  }
  return false;
}

}  // namespace musher::world
