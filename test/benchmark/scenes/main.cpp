// The held scenes of test/modules/skills/scenes/scenes.toml: how each ends, with the gate before
// the base and without it, and what the robots touch, by the geometry of the world. Virtual time;
// the same seed gives the same table.
//
// Beside them the rooms of rooms.toml: how much of them the skill explore covers in 120 s.
//
//   benchmark_scenes [SEED [WORDS]]     WORDS: only scenes whose names have them
//   benchmark_scenes random FIRST COUNT
//
// Random scenes of these seeds, a line a run; it may be stopped at any time.
//
//   benchmark_scenes flyers FIRST COUNT [sensor]
//   benchmark_scenes landings FIRST COUNT [sensor | aside]
//
// The same, only of flyers; they fly above heads and land. With `sensor` they look down, with
// `aside` they also land up to 2 m aside where their place is taken.
//
//   benchmark_scenes sum < LINES
//
// The table of such lines, of one process or of several.
//
// Exit code 1: with the gate there was a contact, a robot has not ended, moves after its end, or
// says that it has arrived elsewhere.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "musher/test/benchmark/scenes/random_runs.hpp"
#include "musher/test/modules/skills/scenes/scene_run.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::benchmark {
namespace {

using skills::testing::RobotOutcome;
using skills::testing::Scene;
using skills::testing::SceneOutcome;
using End = RobotOutcome::End;

struct Total {
  int robots = 0, arrived = 0, refused = 0, failed = 0, open = 0, contacts = 0;
  int not_as_drawn = 0;    // the end of a robot is not what the scene expects
  int false_arrivals = 0;  // it says that it has arrived, and is farther than 0.5 m from its goal
  int moving = 0;          // 2 s after its end
  double least_room_m = 10;

  void Add(const Scene& scene, const SceneOutcome& outcome) {
    for (const RobotOutcome& robot : outcome.robots) {
      ++robots;
      arrived += robot.end == End::kArrived;
      refused += robot.end == End::kRefused;
      failed += robot.end == End::kFailed;
      open += robot.end == End::kOpen;
      contacts += robot.contacts;
      moving += robot.end != End::kOpen && !robot.stands;
      false_arrivals += robot.end == End::kArrived && robot.off_goal_m > 0.5;
      const bool as_drawn = scene.expects == Scene::Expects::kArrives   ? robot.end == End::kArrived
                            : scene.expects == Scene::Expects::kRefuses ? robot.end == End::kRefused
                                                                        : robot.end != End::kOpen;
      not_as_drawn += !as_drawn;
      if (robot.least_room_m < least_room_m) least_room_m = robot.least_room_m;
    }
  }
};

std::string TextOf(const SceneOutcome& outcome) {
  std::string text;
  for (const RobotOutcome& robot : outcome.robots) {
    const char* end = robot.end == End::kArrived   ? "arrived"
                      : robot.end == End::kRefused ? "refused"
                      : robot.end == End::kFailed  ? "failed"
                                                   : "not ended";
    text += (text.empty() ? "" : ", ") + std::string(end);
  }
  return text;
}

void Print(const char* name, const Total& total) {
  std::printf("| %s | %d | %d | %d | %d | %d | %d | %d | %.3f |\n", name, total.arrived,
              total.refused, total.failed, total.open, total.contacts, total.false_arrivals,
              total.not_as_drawn, total.least_room_m);
}

Result<std::vector<Scene>> ScenesOf(const std::string& file) {
  auto scenes = skills::testing::ReadScenes(SourceDir() + "/test/modules/skills/scenes/" + file);
  if (!scenes) std::fprintf(stderr, "benchmark_scenes: %s\n", scenes.error().message.c_str());
  return scenes;
}

int Explore(std::uint64_t seed, const std::string& words) {
  const auto rooms = ScenesOf("rooms.toml");
  if (!rooms) return 2;
  std::printf(
      "\n| explored | free, m2 | covered, %% | s | contacts | end |\n|---|---|---|---|---|---|\n");
  int contacts = 0;
  for (const Scene& room : rooms.value()) {
    if (room.name.find(words) == std::string::npos) continue;
    const auto explored = skills::testing::RunExploration(room, 2, seed);
    std::printf("| %s | %.1f | %.1f | %.0f | %d | %s |\n", room.name.c_str(), explored.free_m2,
                100 * explored.covered, explored.seconds, explored.contacts,
                explored.message.c_str());
    contacts += explored.contacts;
  }
  return contacts > 0 ? 1 : 0;
}

int Run(std::uint64_t seed, const std::string& words) {
  const auto scenes = ScenesOf("scenes.toml");
  if (!scenes) return 2;
  Total gated, free;
  std::string reasons;
  std::printf(
      "| scene | with the gate | s | contacts | without | s | contacts |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const Scene& scene : scenes.value()) {
    if (scene.name.find(words) == std::string::npos) continue;
    const SceneOutcome with = RunScene(scene, true, seed), without = RunScene(scene, false, seed);
    gated.Add(scene, with);
    free.Add(scene, without);
    std::printf("| %s | %s | %.0f | %d | %s | %.0f | %d |\n", scene.name.c_str(),
                TextOf(with).c_str(), with.seconds(), with.contacts(), TextOf(without).c_str(),
                without.seconds(), without.contacts());
    for (const RobotOutcome& robot : with.robots) {
      if (robot.end != End::kArrived) reasons += "- " + scene.name + ": " + robot.message + "\n";
    }
  }
  std::printf(
      "\n| %d robots | arrived | refused | failed | not ended | contacts | said arrived, and not "
      "there | not as drawn | least room, m |\n|---|---|---|---|---|---|---|---|---|\n",
      gated.robots);
  Print("with the gate", gated);
  Print("without", free);
  std::printf("\nWith the gate, not arrived:\n\n%s", reasons.c_str());
  return gated.contacts > 0 || gated.open > 0 || gated.moving > 0 ? 1 : 0;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const std::string mode = argc > 1 ? argv[1] : "";
  if (mode == "sum") return musher::benchmark::AddUpRandomScenes();
  if (mode == "random" || mode == "flyers" || mode == "landings") {
    const std::string sensor = argc > 4 ? argv[4] : "";
    const bool aside = sensor == "aside";
    const musher::benchmark::RandomRunOptions options{mode != "random", aside || sensor == "sensor",
                                                      mode == "landings", aside};
    const auto first = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
    return musher::benchmark::RunRandomScenes(first, argc > 3 ? std::atoi(argv[3]) : 100, options);
  }
  const auto seed = static_cast<std::uint64_t>(argc > 1 ? std::atoll(argv[1]) : 1);
  const std::string words = argc > 2 ? argv[2] : "";
  const int scenes = musher::benchmark::Run(seed, words);
  return std::max(scenes, musher::benchmark::Explore(seed, words));
}
