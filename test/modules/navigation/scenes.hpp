#pragma once
// Held scenes of the whole navigation of one robot: planner, controller and gate among walls that
// its map has or has not, movers, late maps and jumps of the localisation. Deterministic; simulated
// time. With and without the gate.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/navigation/planner/cell_map.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation::testing {

// A disc: a person, or another robot.
struct SceneMover {
  double radius_m = 0.25;
  // Where it is; `robot`: the body.
  std::function<Point(double at_s, const Point& robot)> at;
};

struct Scene {
  std::string kind;  // "maze"
  std::string name;
  CellMap world;
  CellMap map;  // that the robot has at the begin
  std::optional<CellMap> late_map;
  double late_map_s = 0;
  Pose start;
  Pose goal;
  std::vector<SceneMover> movers;
  bool flies = false;
  Point jump;  // of the localisation
  double jump_s = 1e9;
  bool passable = true;  // there is a way
};

struct SceneEnd {
  enum class Kind { kArrived, kRefused, kEndless } kind = Kind::kEndless;
  std::string reason;
  int contacts = 0;            // of a moving body with what stands or comes
  int contacts_of_movers = 0;  // that have come to a body that stands
  double least_room_m = 1;     // to walls
  double seconds = 0;
  int plans = 0;
  std::vector<double> replan_ms;  // CPU
};

std::vector<Scene> HeldScenes();
SceneEnd RunScene(const Scene& scene, bool gated);

}  // namespace musher::navigation::testing
