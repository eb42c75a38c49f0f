#include "musher/modules/world/render/parts.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// In slices across its longest axis: one ball round all of a limb would be as wide as it is long.
void Bound(const Matrix3d& turned, const Vector3d& half_m, Thing& thing) {
  constexpr int kMostSlices = 5;
  int longest = 0;
  const double along_m = half_m.maxCoeff(&longest);
  Vector3d rest_m = half_m;
  rest_m[longest] = 0;
  const double thick_m = rest_m.maxCoeff();
  const int slices = std::clamp(static_cast<int>(std::lround(along_m / thick_m)), 1, kMostSlices);
  const double half_slice_m = along_m / slices;
  for (int i = 0; i < slices; ++i) {
    const double middle_m = half_slice_m * (2 * i + 1 - slices);
    // It is thickest at the slice nearest to its middle.
    const double inner = std::max(0.0, std::abs(middle_m) - half_slice_m) / along_m;
    const double radius_m = std::hypot(half_slice_m, thick_m * std::sqrt(1 - inner * inner));
    const Vector3d at_m = turned.col(longest) * middle_m;
    thing.bounds.push_back(
        {thing.center_m + at_m.cast<float>(), static_cast<float>(std::min(radius_m, along_m))});
  }
}

}  // namespace

Thing Rounded(const Vector3d& center_m, const Matrix3d& turned, const Vector3d& half_m,
              const Light3& color) {
  Thing thing;
  thing.shape = Thing::Shape::kEllipsoid;
  thing.center_m = center_m.cast<float>();
  thing.half_m = half_m.cast<float>();
  const Matrix3d to_unit = half_m.cwiseInverse().asDiagonal() * turned.transpose();
  thing.to_unit = to_unit.cast<float>();
  thing.color = color;
  Bound(turned, half_m, thing);
  return thing;
}

void Parts::Round(const Vector3d& at_m, const Matrix3d& turned, const Vector3d& half_m,
                  const Light3& color) {
  const Vector3d center_m = body_in_place_ * Vector3d(at_m * times_);
  things_.push_back(Rounded(center_m, body_in_place_.linear() * turned, half_m * times_, color));
}

void Parts::Limb(const Vector3d& from_m, const Vector3d& to_m, double radius_m,
                 const Light3& color) {
  const Vector3d along_m = to_m - from_m;
  // Any frame whose x axis is along the limb, which is round. Not by FromTwoVectors() of Eigen,
  // which solves by a decomposition that compiles for 8 s.
  const Vector3d x = along_m.isZero() ? Vector3d(Vector3d::UnitX()) : along_m.normalized();
  const Vector3d y = x.unitOrthogonal();
  Matrix3d turned;
  turned << x, y, x.cross(y);
  Round(from_m + along_m / 2, turned, {along_m.norm() / 2 + 0.6 * radius_m, radius_m, radius_m},
        color);
}

}  // namespace musher::world
