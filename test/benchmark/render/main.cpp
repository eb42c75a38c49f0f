// How long a picture of the world's cameras takes to draw: of the yard, from where the robot
// starts, standing; and to prepare its surfaces once.

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>

#include "musher/modules/world/render.hpp"
#include "musher/modules/world/scene_toml.hpp"

namespace musher::world {
namespace {

Scene Yard() {
  SceneReading reading = ReadSceneFile(MUSHER_CONFIGS "/scenes/yard.toml");
  if (!reading.scene) {
    std::fputs("the yard cannot be read\n", stderr);
    std::exit(1);
  }
  return std::move(*reading.scene);
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

void Prepare(benchmark::State& state) {
  const Scene scene = Yard();
  for ([[maybe_unused]] auto each : state) benchmark::DoNotOptimize(Scenery::Make(scene));
}

BENCHMARK_CAPTURE(Shoot, front, 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Shoot, left, 1)->Unit(benchmark::kMillisecond);
BENCHMARK(Prepare)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace musher::world

BENCHMARK_MAIN();
