#pragma once
// Runs a scene with the product: planner, controller and the skill navigate_to of each robot, by
// the defaults of their config files, on a simulated network in virtual time. With the gate before
// the base, or with one that lets everything pass. The same seed gives the same run.

#include <string>
#include <vector>

#include "musher/test/modules/skills/scenes/scene.hpp"

namespace musher::skills::testing {

struct RobotOutcome {
  enum class End : std::uint8_t { kArrived, kRefused, kFailed, kOpen };

  End end = End::kOpen;  // of navigate_to; refused: no path, and it has not moved
  std::string message;
  double seconds = 0;
  double off_goal_m = 0;  // at its end, in the world
  double travelled_m = 0;
  double least_room_m = 0;
  int contacts = 0;
  int from_above = 0;   // contacts of a flyer that sinks onto what its planar scan does not see
  bool stands = true;   // 2 s after its end
  bool landed = false;  // where the scene says so
  std::string landing;  // the message of that end
};

struct SceneOutcome {
  std::vector<RobotOutcome> robots;
  int hits_of_movers = 0;  // into a robot that stood

  int Count(RobotOutcome::End end) const;
  int contacts() const;
  double seconds() const;  // of the last end
};

SceneOutcome RunScene(const Scene& scene, bool gated, std::uint64_t seed);

struct Exploration {
  double free_m2 = 0;
  double covered = 0;  // the share of it that was within half a lane of the robot
  double seconds = 0;  // to its end, at most limit_s
  std::string message;
  int contacts = 0;
};

// The skill explore of the first robot within the outer walls, with the gate.
Exploration RunExploration(const Scene& scene, double lane_width_m, std::uint64_t seed);

}  // namespace musher::skills::testing
