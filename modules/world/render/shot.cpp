#include "musher/modules/world/render/shot.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "musher/modules/world/paint/mat_pictures.hpp"
#include "musher/modules/world/render/scenery.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::world {

namespace {

std::optional<HumanoidStance> StanceOf(const World& world) {
  const std::optional<Humanoid>& humanoid = world.humanoid();
  if (!humanoid) return std::nullopt;
  HumanoidStance stance{{}, humanoid->hands(), world.scene().body.stand_height_m};
  for (std::size_t i = 0; i < kJoints; ++i) stance.angles[i] = humanoid->joints()[i].position_rad;
  return stance;
}

std::vector<std::size_t> HiddenBalls(const Scene& scene) {
  std::vector<std::size_t> hidden;
  for (std::size_t i = 0; i < scene.balls.size(); ++i) {
    if (!scene.balls[i].shown) hidden.push_back(i);
  }
  return hidden;
}

}  // namespace

View ViewOf(const World& world, std::size_t index) {
  return {.body = world.body().pose(),
          .attitude = world.body().attitude(),
          .seed = NoiseSeed(world.scene(), index, world.now()),
          .gaze = world.gaze(),
          .guests = world.guests(),
          .hidden_balls = HiddenBalls(world.scene()),
          .humanoid = StanceOf(world),
          .moving = world.fleet().MovingSolids(world.scene(), std::nullopt)};
}

View ViewOfRobot(const World& world, std::size_t index) {
  constexpr std::size_t kFirstRobot = 1000;  // other noise than that of the body's cameras
  const RobotBody& body = world.fleet().robots().at(index).body;
  View view;
  view.body = {body.position_m().head<2>(), body.yaw_rad()};
  view.attitude.height_m = body.position_m().z();
  view.seed = NoiseSeed(world.scene(), kFirstRobot + index, world.now());
  view.guests = world.guests();
  view.hidden_balls = HiddenBalls(world.scene());
  view.moving = world.fleet().MovingSolids(world.scene(), index);
  const std::vector<Solid> of_world = world.BodySolid();
  view.moving.insert(view.moving.end(), of_world.begin(), of_world.end());
  return view;
}

Result<Image> TakeShotOfRobot(const World& world, std::size_t index) {
  auto scenery = Scenery::Make(world.scene());
  if (!scenery) return scenery.error();
  return Camera(world.scene().robots.at(index).camera.value())
      .Shoot(*scenery.value(), ViewOfRobot(world, index));
}

Result<Image> TakeShot(const World& world, std::size_t index) {
  const Scene& scene = world.scene();
  auto scenery = Scenery::Make(scene);
  if (!scenery) return scenery.error();
  const Camera camera(scene.cameras.cameras.at(index));
  return camera.Shoot(*scenery.value(), ViewOf(world, index));
}

Result<> SaveImage(const Image& image, const std::string& path) {
  // OpenCV takes no constant data, and changes none of it.
  auto* data = const_cast<std::uint8_t*>(image.bgr.data());
  return SavePng(cv::Mat(image.height, image.width, CV_8UC3, data), path);
}

std::uint64_t NoiseSeed(const Scene& scene, std::size_t index, Duration at) {
  transport::sim::Random of_scene(scene.seed);
  transport::sim::Random of_camera(of_scene.Next() + index);
  return transport::sim::Random(of_camera.Next() + static_cast<std::uint64_t>(at.count())).Next();
}

}  // namespace musher::world
