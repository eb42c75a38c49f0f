// How long a picture of the world's cameras takes to draw: of the yard, from where the robot
// starts, standing, and of the wedding hall while its guests come and go; and to prepare the yard's
// surfaces once. And what a step of the world costs with a humanoid and guests.

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>

#include "musher/modules/world/render/render.hpp"
#include "musher/modules/world/render/shot.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world {
namespace {

Scene Read(const std::string& path) {
  SceneReading reading = ReadSceneFile(path);
  if (!reading.scene) {
    std::fprintf(stderr, "%s cannot be read\n", path.c_str());
    std::exit(1);
  }
  return std::move(*reading.scene);
}

Scene Yard() {
  return Read(SourceDir() + "/config/scenes/yard.toml");
}

Scene Hall() {
  return Read(SourceDir() + "/config/scenes/wedding.toml");
}

void Shoot(benchmark::State& state, std::size_t index) {
  const Scene scene = Yard();
  const auto scenery = Scenery::Make(scene);
  const Camera camera(scene.cameras.cameras[index]);
  View view{scene.start, {scene.body.stand_height_m, 0, 0}};
  for ([[maybe_unused]] auto each : state) {
    ++view.seed;
    view.body.yaw_rad += 0.1;  // once around, so that it is no single picture
    benchmark::DoNotOptimize(camera.Shoot(*scenery.value(), view));
  }
}

// All of its 90 s, a picture a second, with the humanoid that takes a pose or without it.
void ShootGuests(benchmark::State& state, std::size_t index, bool with_humanoid) {
  constexpr int kSeconds = 90;
  World world(Hall());
  static_cast<void>(world.SetPose("heart"));
  std::vector<View> views;
  for (int step = 0; step < kSeconds * 50; ++step) {
    world.Step();
    if (step % 50 == 0) views.push_back(ViewOf(world, index));
    if (step % 50 == 0 && !with_humanoid) views.back().humanoid.reset();
  }
  const auto scenery = Scenery::Make(world.scene());
  const Camera camera(world.scene().cameras.cameras[index]);
  std::size_t next = 0;
  for ([[maybe_unused]] auto each : state) {
    benchmark::DoNotOptimize(camera.Shoot(*scenery.value(), views[next++ % views.size()]));
  }
}

void Step(benchmark::State& state) {
  World world(Hall());
  for ([[maybe_unused]] auto each : state) benchmark::DoNotOptimize(world.Step());
}

void Prepare(benchmark::State& state) {
  const Scene scene = Yard();
  for ([[maybe_unused]] auto each : state) benchmark::DoNotOptimize(Scenery::Make(scene));
}

BENCHMARK_CAPTURE(Shoot, front, 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Shoot, left, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ShootGuests, front, 0, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ShootGuests, front_without_humanoid, 0, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ShootGuests, hall, 1, true)->Unit(benchmark::kMillisecond);
BENCHMARK(Step)->Unit(benchmark::kMicrosecond);
BENCHMARK(Prepare)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace musher::world

BENCHMARK_MAIN();
