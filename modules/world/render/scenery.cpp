#include "musher/modules/world/render/scenery.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/world/paint/surface_paint.hpp"
#include "musher/modules/world/render/figure.hpp"

namespace musher::world {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

Thing Upright(Thing::Shape shape, const Vector2d& center, double bottom_m, double height_m,
              const Vector2d& half, double yaw_rad, const Color& color) {
  Thing thing;
  thing.shape = shape;
  thing.center_m = Vector3d(center.x(), center.y(), bottom_m + height_m / 2).cast<float>();
  thing.half_m = Vector3d(half.x(), half.y(), height_m / 2).cast<float>();
  thing.cos_yaw = static_cast<float>(std::cos(yaw_rad));
  thing.sin_yaw = static_cast<float>(std::sin(yaw_rad));
  thing.color = ToLight(color);
  return thing;
}

// A long thing in several spheres: a single one would be as high as it is long.
void Bound(Thing& thing) {
  if (thing.shape == Thing::Shape::kSphere) {
    thing.bounds = {{thing.center_m, thing.half_m.x()}};
    return;
  }
  constexpr int kMostParts = 16;
  int longest = 0;
  thing.half_m.maxCoeff(&longest);
  const float half = thing.half_m[longest];
  Vector3f rest = thing.half_m;
  rest[longest] = 0;
  const float thick = std::max(rest.norm(), 0.05F);
  const int parts = std::clamp(static_cast<int>(std::ceil(half / thick)), 1, kMostParts);
  Vector3f axis = longest == 2   ? Vector3f(0, 0, 1)
                  : longest == 1 ? Vector3f(-thing.sin_yaw, thing.cos_yaw, 0)
                                 : Vector3f(thing.cos_yaw, thing.sin_yaw, 0);
  const float part = half / static_cast<float>(parts);
  for (int i = 0; i < parts; ++i) {
    const float along = part * static_cast<float>(2 * i + 1 - parts);
    thing.bounds.push_back({thing.center_m + along * axis, std::hypot(rest.norm(), part)});
  }
}

// Planck's law for one wavelength, except for factors that are the same for all.
double Radiance(double wavelength_m, double temperature_k) {
  constexpr double kSecondRadiation = 0.014388;  // m K
  return std::pow(wavelength_m, -5) / std::expm1(kSecondRadiation / (wavelength_m * temperature_k));
}

Thing ToThing(const Box& box) {
  return Upright(Thing::Shape::kBox, box.center_m, box.bottom_m, box.height_m, box.half_m,
                 box.yaw_rad, box.color);
}

Thing ToThing(const Circle& circle) {
  return Upright(Thing::Shape::kCylinder, circle.center_m, circle.bottom_m, circle.height_m,
                 Vector2d::Constant(circle.radius_m), 0, circle.color);
}

}  // namespace

Thing ThingOf(const Solid& solid) {
  Thing thing = std::visit([](const auto& shape) { return ToThing(shape); }, solid.shape);
  Bound(thing);
  return thing;
}

Light3 ToLight(const Color& color) {
  return {float(color.red), float(color.green), float(color.blue)};
}

Light3 TintOf(double temperature_k) {
  constexpr double kDaylightK = 6500;
  constexpr double kWavelengthsM[] = {600e-9, 550e-9, 450e-9};
  Eigen::Array3d tint;
  for (const int i : {0, 1, 2}) {
    tint[i] = Radiance(kWavelengthsM[i], temperature_k) / Radiance(kWavelengthsM[i], kDaylightK);
  }
  constexpr double kRed = 0.3, kGreen = 0.59, kBlue = 0.11;  // what they weigh to the eye
  tint /= kRed * tint[0] + kGreen * tint[1] + kBlue * tint[2];
  return tint.cast<float>();
}

Result<std::unique_ptr<Scenery>> Scenery::Make(const Scene& scene) {
  auto ground = PaintGround(scene);
  if (!ground) return ground.error();
  std::unique_ptr<Scenery> scenery(new Scenery(scene, std::move(ground).value()));
  for (const Board& board : scene.boards) {
    auto front = PaintSign(board);
    if (!front) return front.error();
    Thing thing = Upright(Thing::Shape::kBoard, board.center_m, board.bottom_m, board.height_m,
                          {0, board.width_m / 2}, board.yaw_rad, board.color);
    thing.round = board.round;
    thing.front = std::make_shared<const Texture>(std::move(front).value());
    Bound(thing);
    scenery->things_.push_back(std::move(thing));
  }
  for (const GuestSpec& guest : scene.guests) {
    auto face = PaintHead(guest.face);
    if (!face) return face.error();
    scenery->figures_.emplace_back(guest, std::move(face).value());
  }
  return scenery;
}

Scenery::~Scenery() = default;

std::vector<Thing> Scenery::With(const std::vector<Guest>& guests,
                                 const std::vector<std::size_t>& hidden_balls) const {
  std::vector<Thing> all = things_;
  for (std::size_t i = hidden_balls.size(); i > 0; --i) {
    all.erase(all.begin() + static_cast<std::ptrdiff_t>(first_ball_ + hidden_balls[i - 1]));
  }
  for (std::size_t i = 0; i < std::min(guests.size(), figures_.size()); ++i) {
    if (guests[i].here) figures_[i].Stand(guests[i], all);
  }
  return all;
}

Scenery::Scenery(const Scene& scene, Texture ground)
    : ground_(std::move(ground)),
      least_m_(scene.least_m.cast<float>()),
      most_m_(scene.most_m.cast<float>()),
      fence_height_m_(static_cast<float>(scene.fence_height_m)),
      fence_color_(ToLight(scene.fence_color)),
      sky_(ToLight(scene.light.sky)),
      tint_(TintOf(scene.light.temperature_k) * static_cast<float>(scene.light.brightness)),
      towards_light_(TowardsLight(scene.light).cast<float>()),
      ambient_(static_cast<float>(scene.light.ambient)),
      shadows_(scene.light.shadows),
      light_in_shadow_(static_cast<float>(LightInShadow(scene.light))) {
  texels_per_m_ = static_cast<float>(ground_.width()) / (most_m_.x() - least_m_.x());
  Dim(scene);
  for (const Box& box : scene.boxes) things_.push_back(ToThing(box));
  for (const Circle& circle : scene.circles) things_.push_back(ToThing(circle));
  first_ball_ = things_.size();
  for (const Ball& ball : scene.balls) {
    Thing thing;
    thing.shape = Thing::Shape::kSphere;
    thing.center_m = ball.center_m.cast<float>();
    thing.half_m = Vector3f::Constant(static_cast<float>(ball.radius_m));
    // Paint of its colour in the light of a hall is darker.
    constexpr float kLampBesidePaint = 1.5F;
    thing.color = ToLight(ball.color) * (ball.glows ? kLampBesidePaint : 1.0F);
    thing.glows = ball.glows;
    things_.push_back(std::move(thing));
  }
  for (Thing& thing : things_) Bound(thing);
}

// From full light at one end of the place to what is left at the other.
void Scenery::Dim(const Scene& scene) {
  const Lighting& light = scene.light;
  const Vector2d towards(std::cos(light.gradient_yaw_rad), std::sin(light.gradient_yaw_rad));
  const Vector2d half = (scene.most_m - scene.least_m) / 2;
  const double reach = half.dot(towards.cwiseAbs());
  const Vector2d each_m = towards * light.gradient / (2 * reach);
  const Vector2d middle = (scene.most_m + scene.least_m) / 2;
  dim_x_ = static_cast<float>(each_m.x());
  dim_y_ = static_cast<float>(each_m.y());
  dim_from_ = static_cast<float>(1 - light.gradient / 2 + each_m.dot(middle));
  least_light_ = static_cast<float>(1 - light.gradient);
}

}  // namespace musher::world
