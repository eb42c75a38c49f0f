// Held scenes of the whole navigation, with and without the gate before the body: arrivals,
// refusals, contacts; and how long a new plan takes.
//
//   benchmark_scenes [KIND]    of the scenes; default: all

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/modules/navigation/scenes.hpp"

namespace musher::benchmark {
namespace {

using navigation::testing::HeldScenes;
using navigation::testing::RunScene;
using navigation::testing::Scene;
using navigation::testing::SceneEnd;

struct Count {
  int scenes = 0, passable = 0, arrived = 0, refused = 0, endless = 0;
  int contacts = 0, of_movers = 0;  // scenes with one
};

void Add(const Scene& scene, const SceneEnd& end, Count& count) {
  ++count.scenes;
  count.passable += scene.passable;
  count.arrived += end.kind == SceneEnd::Kind::kArrived;
  count.refused += end.kind == SceneEnd::Kind::kRefused;
  count.endless += end.kind == SceneEnd::Kind::kEndless;
  count.contacts += end.contacts > 0;
  count.of_movers += end.contacts_of_movers > 0;
}

void Print(const std::string& kind, const Count& gated, const Count& bare) {
  std::printf("| %s | %d | %d | %d | %d | %d | %d | %d | %d | %d |\n", kind.c_str(), gated.scenes,
              gated.passable, gated.arrived, gated.refused, gated.contacts, gated.of_movers,
              bare.arrived, bare.refused, bare.contacts);
}

int Run(const std::string& only) {
  std::vector<std::string> kinds;
  std::map<std::string, Count> gated, bare;
  std::vector<double> replans;
  Count all_gated, all_bare;
  for (const Scene& scene : HeldScenes()) {
    if (!only.empty() && scene.kind != only) continue;
    if (gated.count(scene.kind) == 0) kinds.push_back(scene.kind);
    const SceneEnd end = RunScene(scene, true);
    replans.insert(replans.end(), end.replan_ms.begin(), end.replan_ms.end());
    std::fprintf(stderr, "%s, %s: %s after %.0f s, %d plans, %d contacts, room %.3f m. %s\n",
                 scene.kind.c_str(), scene.name.c_str(),
                 end.kind == SceneEnd::Kind::kArrived ? "arrived" : "not arrived", end.seconds,
                 end.plans, end.contacts, end.least_room_m, end.reason.c_str());
    const SceneEnd without = RunScene(scene, false);
    for (auto* count : {&gated[scene.kind], &all_gated}) Add(scene, end, *count);
    for (auto* count : {&bare[scene.kind], &all_bare}) Add(scene, without, *count);
  }
  std::printf(
      "| scenes | number | with a way | arrived | refused | a contact | a mover's contact | "
      "without the gate: arrived | refused | a contact |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& kind : kinds) Print(kind, gated[kind], bare[kind]);
  Print("all", all_gated, all_bare);
  if (!replans.empty()) {
    std::printf("\nNew plans: %zu; CPU ms, median %.3g, p99 %.3g, highest %.3g.\n", replans.size(),
                Median(replans), Quantile(replans, 0.99), Quantile(replans, 1));
  }
  return kinds.empty() ? 2 : all_gated.contacts > 0 || all_gated.endless > 0;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  return musher::benchmark::Run(argc > 1 ? argv[1] : "");
}
