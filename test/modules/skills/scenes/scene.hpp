#pragma once
// A held scene: a world, drawn, with what its map says wrongly, movers, faults and robots with
// their goals. Scenes are data, in scenes.toml beside this file, which explains the keys and the
// characters of a map; nothing of the product is used to read or to check them.
//
// Metres, radians, seconds from the moment when the robots get their goals.

#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::skills::testing {

struct SceneMover {
  std::vector<navigation::Point> path;  // to its end and back again
  double speed_m_s = 0.6;
  double radius_m = 0.25;
  double height_m = 1.8;
  double begins_s = 0;
  double waits_s = 0;     // at each place of its path but the first
  bool stays = false;     // at the end of its path
  bool yields = true;     // stops before a robot
  double yields_m = 0.3;  // so far from it
  double turns_s = 1e9;   // after which it turns round where a robot is in its way
};

struct SceneEvent {
  enum class Kind : std::uint8_t {
    kJump,        // of the localisation, by (x, y); with `lasts` until it is corrected
    kFreeze,      // the pose of the odometry stands, its stamps do not
    kNoOdometry,  // none comes
    kNoScan,      // none comes
    kStuck,       // the wheels turn, the body does not move
    kMap,         // the map comes again, with what is drawn as '%'
  };
  Kind kind = Kind::kMap;
  double at_s = 0;
  double lasts_s = 0;  // 0: to the end
  double x_m = 0, y_m = 0;
};

struct SceneRobot {
  navigation::Pose start;
  navigation::Pose goal;
  int priority = 0;
};

struct Scene {
  enum class Expects : std::uint8_t { kArrives, kRefuses, kEnds };

  std::string name;
  std::vector<std::string> map;  // the first line is the one with the highest y
  double cell_m = 0.25;
  bool flies = false;
  bool looks_down = false;   // a flyer has a sensor for it
  bool only_heads = false;   // of persons, for that sensor: their trousers reflect nothing
  bool lands = false;        // a flyer, where its drive has ended
  double aside_m = 0;        // so far from there, where its place is taken
  bool map_is_late = false;  // it comes with the first event kMap only
  Expects expects = Expects::kArrives;
  double limit_s = 150;  // a robot that has not ended by then has not ended at all
  std::vector<SceneRobot> robots;
  std::vector<SceneMover> movers;
  std::vector<SceneEvent> events;

  char At(int x, int y) const;  // '#' outside
  int width() const { return static_cast<int>(map.front().size()); }
  int height() const { return static_cast<int>(map.size()); }
  bool IsWall(int x, int y) const;                    // in the world
  bool IsMapped(int x, int y, bool with_late) const;  // in the map
};

// All scenes of a file. Fails with its first error.
Result<std::vector<Scene>> ReadScenes(const std::string& path);

}  // namespace musher::skills::testing
