#include "musher/modules/world/render/trace.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "musher/modules/world/render/meet.hpp"

namespace musher::world {
namespace {

using Eigen::Array3f;
using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kLevel = -1e-6F;  // rays that go down less than this meet no ground

constexpr std::uint16_t kSky = 1;
constexpr std::uint16_t kFarGround = 2;
constexpr std::uint16_t kGroundLabel = 3;
constexpr std::uint16_t kFence = 4;  // and three more, one for each side
constexpr std::uint16_t kThings = 16;
constexpr std::uint16_t kFaces = 8;  // numbers that each thing has

constexpr float kShadowRim2 = 1.7F;  // where the body's shadow ends, in squares of its size

Light3 LightOf(Texel texel) {
  return {float(texel >> 16 & 0xFF), float(texel >> 8 & 0xFF), float(texel & 0xFF)};
}

void Put(const Light3& light, std::size_t i, Sights& sights) {
  sights.red[i] = light[0];
  sights.green[i] = light[1];
  sights.blue[i] = light[2];
}

// It is darker near the ground.
float NearGround(float height_m) {
  const float share = 0.72F + 1.4F * height_m;
  return share < 1 ? share : 1;
}

float Tone(std::int32_t plank) {
  const auto mixed = static_cast<std::uint32_t>(plank) * 2654435761U;
  return static_cast<float>(static_cast<std::int32_t>(mixed >> 24)) / 255 - 0.5F;
}

float Within1(float share) {
  const float least = share > 0 ? share : 0;
  return least < 1 ? least : 1;
}

}  // namespace

Tracer::Tracer(const Scenery& scenery, const std::vector<Thing>& things,
               const Eigen::Isometry3d& camera_in_place, const Pose2& body, double trunk_m,
               double pixel_rad)
    : scenery_(scenery),
      things_(things),
      turn_(camera_in_place.linear().cast<float>()),
      from_m_(camera_in_place.translation().cast<float>()),
      pixel_rad_(static_cast<float>(pixel_rad)) {
  from_m_.z() = std::max(from_m_.z(), 0.005F);  // not below the ground when the body falls
  const Vector2f at = from_m_.head<2>();
  fenced_ = scenery.fence_height_m() > 0 && (at - scenery.least_m()).minCoeff() > kNearest &&
            (scenery.most_m() - at).minCoeff() > kNearest;
  for (const Thing& thing : things_) {
    const Vector3f from = from_m_ - thing.center_m;
    if (thing.shape == Thing::Shape::kEllipsoid) {
      from_local_.emplace_back(thing.to_unit * from);
      continue;
    }
    from_local_.emplace_back(thing.cos_yaw * from.x() + thing.sin_yaw * from.y(),
                             -thing.sin_yaw * from.x() + thing.cos_yaw * from.y(), from.z());
  }
  light_on_ground_ = scenery.LightOn({0, 0, 1});
  // The inner sides, by the way out: x, -x, y, -y.
  const Vector3f inwards[] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}};
  for (int i = 0; i < 4; ++i) {
    fence_light_[i] = scenery.fence_color() / 255 * scenery.LightOn(inwards[i]) * 255;
  }
  far_ground_ = world::LightOf(scenery.ground().mean()) * light_on_ground_;
  zenith_ = scenery.sky() * scenery.tint();
  horizon_ = (0.45F * scenery.sky() + 0.55F * Array3f(244, 246, 246)) * scenery.tint();
  const Vector3f& light = scenery.towards_light();
  shadow_m_ = body.position_m.cast<float>() - light.head<2>() / light.z() * (0.7F * float(trunk_m));
  shadow_cos_ = static_cast<float>(std::cos(body.yaw_rad));
  shadow_sin_ = static_cast<float>(std::sin(body.yaw_rad));
  shadow_half_m_ = {0.3F, 0.16F};
}

void Tracer::Look(const Rays& rays, const Indices& things, Sights& sights) const {
  Paths paths;
  Turn(rays, paths);
  FindBackground(paths, sights);
  // Most bundles are all sky or all ground.
  const auto begin = sights.surface.begin();
  if (std::find(begin, sights.surface.end(), kSky) != sights.surface.end()) ColorSky(paths, sights);
  if (std::find(begin, sights.surface.end(), kGroundLabel) != sights.surface.end()) {
    FindGround(rays, paths);
    ColorGround(paths, sights);
  }
  ColorBackground(paths, sights);
  for (const std::uint16_t thing : things) {
    const bool ellipsoid = things_[thing].shape == Thing::Shape::kEllipsoid;
    ellipsoid ? FindEllipsoid(thing, paths, sights) : FindThing(thing, paths, sights);
  }
}

void Tracer::Turn(const Rays& rays, Paths& paths) const {
  const auto turn = [&rays](float x, float y, float z, Each<float>& into) {
    for (std::size_t i = 0; i < kBundle; ++i) {
      into[i] = x * rays.x[i] + y * rays.y[i] + z * rays.z[i];
    }
  };
  turn(turn_(0, 0), turn_(0, 1), turn_(0, 2), paths.x);
  turn(turn_(1, 0), turn_(1, 1), turn_(1, 2), paths.y);
  turn(turn_(2, 0), turn_(2, 1), turn_(2, 2), paths.z);
}

// Finds which of fence, ground and sky is hit, and how far.
void Tracer::FindBackground(Paths& paths, Sights& sights) const {
  constexpr float kTinyLength = 1e-9F;
  const Vector2f to_most = scenery_.most_m() - from_m_.head<2>();
  const Vector2f to_least = scenery_.least_m() - from_m_.head<2>();
  const auto to_edge = [](float least, float most, const Each<float>& along, Each<float>& far) {
    for (std::size_t i = 0; i < kBundle; ++i) {
      const float way = along[i];
      const float edge = way >= 0 ? most : least;
      const float tiny = way >= 0 ? kTinyLength : -kTinyLength;
      far[i] = edge / (way + tiny);
    }
  };
  Each<float> by_x, by_y;
  to_edge(to_least.x(), to_most.x(), paths.x, by_x);
  to_edge(to_least.y(), to_most.y(), paths.y, by_y);
  const float height = from_m_.z();
  const float fence = fenced_ ? scenery_.fence_height_m() : -kFar;
  Each<std::int32_t> surface;
  for (std::size_t i = 0; i < kBundle; ++i) {
    const float z = paths.z[i];
    const std::int32_t side_x = paths.x[i] >= 0 ? kFence : kFence + 1;
    const std::int32_t side_y = paths.y[i] >= 0 ? kFence + 2 : kFence + 3;
    const std::int32_t side = by_x[i] < by_y[i] ? side_x : side_y;
    const float far = by_x[i] < by_y[i] ? by_x[i] : by_y[i];
    const float down = z < kLevel ? z : -1;
    const float to_ground = z < kLevel ? -height / down : kFar;
    const std::int32_t beyond = z < kLevel ? kFarGround : kSky;
    const float above = height + far * z;  // where it leaves the place
    const std::int32_t outside = above < fence ? side : beyond;
    surface[i] = to_ground <= far ? kGroundLabel : outside;
    const float least = above < fence ? far : kFar;
    paths.far_m[i] = least < to_ground ? least : to_ground;
  }
  for (std::size_t i = 0; i < kBundle; ++i) {
    sights.surface[i] = static_cast<std::uint16_t>(surface[i]);
  }
}

// Where it is met, and how much of it a pixel covers. Only valid where the ground is met.
void Tracer::FindGround(const Rays& rays, Paths& paths) const {
  const float per_m = scenery_.texels_per_m();
  const float fine = 256 * per_m;  // parts of a texel in a metre
  const Vector2f from = from_m_.head<2>() - scenery_.least_m();
  const Vector2f most = (scenery_.most_m() - scenery_.least_m()) * fine;
  const float covered = pixel_rad_ * per_m;
  const Vector2f at = from_m_.head<2>();
  for (std::size_t i = 0; i < kBundle; ++i) {
    const float far = paths.far_m[i] < 1e4F ? paths.far_m[i] : 1e4F;
    const float x = (from.x() + far * paths.x[i]) * fine;
    const float y = (from.y() + far * paths.y[i]) * fine;
    const float right = x > 0 ? x : 0;
    const float up = y > 0 ? y : 0;
    paths.column[i] = static_cast<std::int32_t>(right < most.x() ? right : most.x());
    paths.row[i] = static_cast<std::int32_t>(up < most.y() ? up : most.y());
    const float steep = paths.z[i] < -1e-4F ? -paths.z[i] : 1e-4F;
    const float side = far * covered;
    paths.halvings[i] =
        static_cast<std::int32_t>(0.5F * RoughLog2(side * side / steep) + rays.dither[i]);
  }
  for (std::size_t i = 0; i < kBundle; ++i) {
    const float far = paths.far_m[i] < 1e4F ? paths.far_m[i] : 1e4F;
    paths.light[i] = scenery_.LightAt(at.x() + far * paths.x[i], at.y() + far * paths.y[i]);
  }
  if (scenery_.shadows()) ShadowOfBody(paths);
}

void Tracer::ShadowOfBody(Paths& paths) const {
  const Vector2f from = from_m_.head<2>() - shadow_m_;
  const Vector2f along_m(shadow_cos_ / shadow_half_m_.x(), shadow_sin_ / shadow_half_m_.x());
  const Vector2f across_m(-shadow_sin_ / shadow_half_m_.y(), shadow_cos_ / shadow_half_m_.y());
  const float missing = 1 - scenery_.light_in_shadow();
  for (std::size_t i = 0; i < kBundle; ++i) {
    const float far = paths.far_m[i] < 1e4F ? paths.far_m[i] : 1e4F;
    const float x = from.x() + far * paths.x[i];
    const float y = from.y() + far * paths.y[i];
    const float along = along_m.x() * x + along_m.y() * y;
    const float across = across_m.x() * x + across_m.y() * y;
    const float out2 = along * along + across * across;
    // Full in the middle, nothing at the rim.
    const float share = out2 < kShadowRim2 ? 1 - out2 / kShadowRim2 : 0;
    const float full = 1.8F * share;
    paths.light[i] *= 1 - missing * (full < 1 ? full : 1);
  }
}

void Tracer::ColorSky(const Paths& paths, Sights& sights) const {
  const Light3 from = horizon_;
  const Light3 by = zenith_ - horizon_;
  for (std::size_t i = 0; i < kBundle; ++i) {
    const float up = paths.z[i] > 0 ? 1.6F * paths.z[i] : 0;
    const float share = std::sqrt(up < 1 ? up : 1);
    sights.red[i] = from[0] + share * by[0];
    sights.green[i] = from[1] + share * by[1];
    sights.blue[i] = from[2] + share * by[2];
  }
}

void Tracer::ColorGround(const Paths& paths, Sights& sights) const {
  const Texture& ground = scenery_.ground();
  Each<std::int32_t> texels;
  for (std::size_t i = 0; i < kBundle; ++i) {
    texels[i] =
        static_cast<std::int32_t>(ground.At(paths.column[i], paths.row[i], paths.halvings[i]));
  }
  const Light3 light = light_on_ground_;
  const auto color = [&](Each<float>& own, int shift, float part) {
    for (std::size_t i = 0; i < kBundle; ++i) {
      const float here = static_cast<float>(texels[i] >> shift & 0xFF) * part * paths.light[i];
      own[i] = sights.surface[i] == kGroundLabel ? here : own[i];
    }
  };
  color(sights.red, 16, light[0]);
  color(sights.green, 8, light[1]);
  color(sights.blue, 0, light[2]);
}

void Tracer::ColorBackground(const Paths& paths, Sights& sights) const {
  std::array<bool, kThings> is_there{};
  for (const std::uint16_t surface : sights.surface) is_there[surface] = true;
  for (std::uint16_t side = kFence; side < kFence + 4; ++side) {
    if (is_there[side]) ColorFence(paths, side, sights);
  }
  for (std::size_t i = 0; is_there[kFarGround] && i < kBundle; ++i) {
    if (sights.surface[i] == kFarGround) Put(FarGround(paths.far_m[i]), i, sights);
  }
}

Light3 Tracer::FarGround(float far_m) const {
  constexpr float kHazeM = 40;
  const float haze = far_m / (far_m + kHazeM);
  return far_ground_ + haze * (horizon_ - far_ground_);
}

// Planks, as long as they can be distinguished.
void Tracer::ColorFence(const Paths& paths, std::uint16_t surface, Sights& sights) const {
  constexpr float kPlankM = 0.14F;
  const bool by_x = surface < kFence + 2;
  const Each<float>& across = by_x ? paths.x : paths.y;
  const Each<float>& along = by_x ? paths.y : paths.x;
  const float from = by_x ? from_m_.y() : from_m_.x();
  const float at_x = from_m_.x(), at_y = from_m_.y(), height = from_m_.z();
  const float pixel_rad = pixel_rad_;
  Each<float> share;  // of the light
  for (std::size_t i = 0; i < kBundle; ++i) {
    const float far = paths.far_m[i] < 1e4F ? paths.far_m[i] : 1e4F;
    const float place = (from + far * along[i]) / kPlankM + 0x10000;  // never below 0
    const auto plank = static_cast<std::int32_t>(place);
    const float in_plank = place - static_cast<float>(plank);
    const float from_edge = in_plank < 0.5F ? in_plank : 1 - in_plank;
    const float steep = std::abs(across[i]);
    const float covered = far * pixel_rad / ((steep > 0.05F ? steep : 0.05F) * kPlankM);
    const float distinct = Within1(1.3F - 3 * covered);
    const float gap = Within1(1 - from_edge / 0.09F);
    const float shade = 1 + distinct * (0.16F * Tone(plank) - 0.45F * gap);
    share[i] = shade * NearGround(height + far * paths.z[i]) *
               scenery_.LightAt(at_x + far * paths.x[i], at_y + far * paths.y[i]);
  }
  const Light3& light = fence_light_[surface - kFence];
  const auto color = [&](Each<float>& own, float part) {
    for (std::size_t i = 0; i < kBundle; ++i) {
      const float here = part * share[i];
      own[i] = sights.surface[i] == surface ? here : own[i];
    }
  };
  color(sights.red, light[0]);
  color(sights.green, light[1]);
  color(sights.blue, light[2]);
}

void Tracer::FindThing(std::size_t index, Paths& paths, Sights& sights) const {
  const Thing& thing = things_[index];
  const Vector3f from = from_local_[index];
  const auto first = kThings + index * kFaces;
  for (std::size_t i = 0; i < kBundle; ++i) {
    const Vector3f ray(thing.cos_yaw * paths.x[i] + thing.sin_yaw * paths.y[i],
                       thing.cos_yaw * paths.y[i] - thing.sin_yaw * paths.x[i], paths.z[i]);
    Hit hit;
    if (!Meets(thing, from, ray, hit.far_m, hit.face) || hit.far_m >= paths.far_m[i]) continue;
    paths.far_m[i] = hit.far_m;
    sights.surface[i] = static_cast<std::uint16_t>(first + static_cast<std::size_t>(hit.face));
    Put(LightOf(thing, from, ray, hit), i, sights);
  }
}

Light3 Tracer::LightOf(const Thing& thing, const Vector3f& from, const Vector3f& ray,
                       const Hit& hit) const {
  if (thing.glows) return thing.color;
  const Vector3f where = from + hit.far_m * ray;
  const auto outwards = [&](const Vector3f& local) {
    return Vector3f(thing.cos_yaw * local.x() - thing.sin_yaw * local.y(),
                    thing.sin_yaw * local.x() + thing.cos_yaw * local.y(), local.z());
  };
  const Vector3f in_place = thing.center_m + outwards(where);
  const float light = scenery_.LightAt(in_place.x(), in_place.y());
  if (thing.shape == Thing::Shape::kBoard) {
    return LightOfBoard(thing, where, std::abs(ray.x()), hit) * light;
  }
  Vector3f normal = Vector3f::Zero();
  if (hit.face == kRound) {
    normal = where;
    if (thing.shape == Thing::Shape::kCylinder) normal.z() = 0;
    normal /= thing.half_m.x();
  } else {
    normal[hit.face] = ray[hit.face] < 0 ? 1.0F : -1.0F;
  }
  const float near_ground = hit.face == kFaceZ ? 1 : NearGround(in_place.z());
  return thing.color * scenery_.LightOn(outwards(normal)) * (light * near_ground);
}

Light3 Tracer::LightOfBoard(const Thing& thing, const Vector3f& where, float slant,
                            const Hit& hit) const {
  const float way = hit.face == kFront ? 1.0F : -1.0F;
  const Light3 light = scenery_.LightOn({way * thing.cos_yaw, way * thing.sin_yaw, 0});
  if (hit.face == kBack || !thing.front) return thing.color * light;
  const Texture& front = *thing.front;
  const float per_y = static_cast<float>(front.width()) / (2 * thing.half_m.y());
  const float per_z = static_cast<float>(front.height()) / (2 * thing.half_m.z());
  const float covered = hit.far_m * pixel_rad_;
  const float area = covered * covered / slant * per_y * per_z;  // in texels
  return world::LightOf(front.Smooth((where.y() + thing.half_m.y()) * per_y,
                                     (thing.half_m.z() - where.z()) * per_z,
                                     0.5F * RoughLog2(area))) *
         light;
}

// Guests consist of many ellipsoids, which fill the picture when near: all rays at once.
void Tracer::FindEllipsoid(std::size_t index, Paths& paths, Sights& sights) const {
  const Thing& thing = things_[index];
  const Eigen::Matrix3f& unit = thing.to_unit;
  const Vector3f from = from_local_[index];
  Each<float> far_m;
  for (std::size_t i = 0; i < kBundle; ++i) {
    const float x = unit(0, 0) * paths.x[i] + unit(0, 1) * paths.y[i] + unit(0, 2) * paths.z[i];
    const float y = unit(1, 0) * paths.x[i] + unit(1, 1) * paths.y[i] + unit(1, 2) * paths.z[i];
    const float z = unit(2, 0) * paths.x[i] + unit(2, 1) * paths.y[i] + unit(2, 2) * paths.z[i];
    const float each = 1 / (x * x + y * y + z * z);
    const float middle = -(from.x() * x + from.y() * y + from.z() * z) * each;
    const float aside_x = from.x() + middle * x;
    const float aside_y = from.y() + middle * y;
    const float aside_z = from.z() + middle * z;
    const float under = 1 - (aside_x * aside_x + aside_y * aside_y + aside_z * aside_z);
    const float half2 = under * each;
    const float far = middle - std::sqrt(half2 > 0 ? half2 : 0);
    const float met = under > 0 ? far : kFar;
    far_m[i] = met > kNearest ? met : kFar;
  }
  const auto surface = static_cast<std::uint16_t>(kThings + index * kFaces + kRound);
  for (std::size_t i = 0; i < kBundle; ++i) {
    if (far_m[i] >= paths.far_m[i]) continue;
    paths.far_m[i] = far_m[i];
    sights.surface[i] = surface;
    const Vector3f way = far_m[i] * Vector3f(paths.x[i], paths.y[i], paths.z[i]);
    Put(LightOfEllipsoid(thing, from + unit * way, from_m_ + way, far_m[i]), i, sights);
  }
}

Light3 Tracer::LightOfEllipsoid(const Thing& thing, const Vector3f& on_unit, const Vector3f& where,
                                float far_m) const {
  const Vector3f normal = (thing.to_unit.transpose() * on_unit).normalized();
  const Light3 light = scenery_.LightOn(normal) * scenery_.LightAt(where.x(), where.y());
  if (!thing.front || on_unit.x() <= 0) return thing.color * (light * NearGround(where.z()));
  const Texture& front = *thing.front;
  const auto half_width = static_cast<float>(front.width()) / 2;
  const auto half_height = static_cast<float>(front.height()) / 2;
  const float covered = far_m * pixel_rad_;
  const float area =
      covered * covered * half_width * half_height / (thing.half_m.y() * thing.half_m.z());
  return world::LightOf(front.Smooth((on_unit.y() + 1) * half_width,
                                     (1 - on_unit.z()) * half_height, 0.5F * RoughLog2(area))) *
         light;
}

}  // namespace musher::world
