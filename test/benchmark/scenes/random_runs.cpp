#include "musher/test/benchmark/scenes/random_runs.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <map>
#include <sstream>
#include <string>

#include "musher/test/modules/skills/scenes/random_scene.hpp"
#include "musher/test/modules/skills/scenes/scene_run.hpp"

namespace musher::benchmark {
namespace {

using skills::testing::RobotOutcome;
using skills::testing::Scene;
using skills::testing::SceneEvent;
using skills::testing::SceneOutcome;
using End = RobotOutcome::End;

std::atomic<bool> stopped{false};

void OnSignal(int /*signal*/) {
  stopped = true;
}

// Of the robots of one run, or of several.
struct Counts {
  int runs = 0, robots = 0, arrived = 0, refused = 0, failed = 0, open = 0, contacts = 0;
  int false_arrivals = 0;  // says that it has arrived, is farther than 0.5 m away, without a jump
  int moving = 0;          // 2 s after its end
  int hits = 0;            // of persons into a robot that stood
  int from_above = 0;      // contacts of flyers that sink onto a person
  int landed = 0;

  void Add(const Counts& other) {
    runs += other.runs;
    robots += other.robots;
    arrived += other.arrived;
    refused += other.refused;
    failed += other.failed;
    open += other.open;
    contacts += other.contacts;
    false_arrivals += other.false_arrivals;
    moving += other.moving;
    hits += other.hits;
    from_above += other.from_above;
    landed += other.landed;
  }
  bool wrong() const { return contacts > 0 || open > 0 || moving > 0 || false_arrivals > 0; }
};

Counts CountsOf(const Scene& scene, const SceneOutcome& outcome) {
  bool jumps = false;
  for (const SceneEvent& event : scene.events) jumps |= event.kind == SceneEvent::Kind::kJump;
  Counts counts;
  counts.runs = 1;
  counts.hits = outcome.hits_of_movers;
  for (const RobotOutcome& robot : outcome.robots) {
    ++counts.robots;
    counts.arrived += robot.end == End::kArrived;
    counts.refused += robot.end == End::kRefused;
    counts.failed += robot.end == End::kFailed;
    counts.open += robot.end == End::kOpen;
    counts.contacts += robot.contacts;
    counts.from_above += robot.from_above;
    counts.landed += robot.landed;
    counts.moving += robot.end != End::kOpen && !robot.stands;
    counts.false_arrivals += robot.end == End::kArrived && robot.off_goal_m > 0.5 && !jumps;
  }
  return counts;
}

constexpr const char* kColumns =
    "robots arrived refused failed open contacts false_arrivals moving hits from_above landed";

void PrintRun(std::uint64_t seed, const Scene& scene, const SceneOutcome& outcome) {
  const Counts one = CountsOf(scene, outcome);
  std::printf("run %llu %d %d %d %d %d %d %d %d %d %d %d %.0f s: %s\n",
              static_cast<unsigned long long>(seed), one.robots, one.arrived, one.refused,
              one.failed, one.open, one.contacts, one.false_arrivals, one.moving, one.hits,
              one.from_above, one.landed, outcome.seconds(), scene.name.c_str());
  for (const RobotOutcome& robot : outcome.robots) {
    if (!scene.lands || robot.landed) continue;
    std::printf("# %llu: has not landed: %s\n", static_cast<unsigned long long>(seed),
                robot.landing.c_str());
  }
  if (!one.wrong()) return;
  for (const RobotOutcome& robot : outcome.robots) {
    std::printf("# %llu: %d contacts, least room %.3f m, %s: %s\n",
                static_cast<unsigned long long>(seed), robot.contacts, robot.least_room_m,
                robot.end == End::kOpen ? "has not ended" : "has ended", robot.message.c_str());
  }
}

// False: the line is none of a run.
bool ReadRun(const std::string& line, Counts& counts, std::string& name) {
  std::istringstream words(line);
  std::string word, unit;
  std::uint64_t seed = 0;
  double seconds = 0;
  Counts one;
  words >> word >> seed >> one.robots >> one.arrived >> one.refused >> one.failed >> one.open >>
      one.contacts >> one.false_arrivals >> one.moving >> one.hits >> one.from_above >>
      one.landed >> seconds >> unit;
  if (!words || word != "run") return false;
  std::getline(words >> std::ws, name);
  one.runs = 1;
  counts = one;
  return true;
}

void PrintCounts(const std::string& what, const Counts& all) {
  std::printf("| %s | %d | %d | %d | %d | %d | %d | %d | %d | %d | %d | %d | %d |\n", what.c_str(),
              all.runs, all.robots, all.arrived, all.refused, all.failed, all.open, all.contacts,
              all.false_arrivals, all.moving, all.hits, all.from_above, all.landed);
}

}  // namespace

int RunRandomScenes(std::uint64_t first, int count, const RandomRunOptions& options) {
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGINT, OnSignal);
  std::printf("# run seed %s seconds\n", kColumns);
  bool wrong = false;
  for (std::uint64_t seed = first; count > 0 && !stopped; ++seed) {
    Scene scene =
        options.lands ? skills::testing::LandingScene(seed) : skills::testing::RandomScene(seed);
    if (options.flyers && !scene.flies) continue;
    --count;
    scene.looks_down = scene.flies && options.looks_down;
    scene.aside_m = options.aside ? 2 : 0;
    const SceneOutcome outcome = RunScene(scene, true, seed);
    PrintRun(seed, scene, outcome);
    wrong = wrong || CountsOf(scene, outcome).wrong();
  }
  return wrong ? 1 : 0;
}

int AddUpRandomScenes() {
  Counts all;
  std::map<std::string, Counts> with;  // by each word of a name
  for (std::string line; std::getline(std::cin, line);) {
    Counts one;
    std::string name;
    if (!ReadRun(line, one, name)) continue;
    all.Add(one);
    for (std::size_t begin = 0; begin < name.size();) {
      const std::size_t end = std::min(name.find(", ", begin), name.size());
      with[name.substr(begin, end - begin)].Add(one);
      begin = end + 2;
    }
  }
  std::printf(
      "| random scenes | runs | robots | arrived | refused | failed | not ended | contacts | said "
      "arrived, and not there | moving after the end | hits of persons | sunk onto persons | "
      "landed |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  PrintCounts("all", all);
  for (const auto& [word, counts] : with) PrintCounts(word, counts);
  if (all.runs == 0) return 2;
  return all.wrong() ? 1 : 0;
}

}  // namespace musher::benchmark
