#pragma once
// Watches a run of a course, unseen by the robot: which zones it reaches and in which order, where
// its feet are on watched lines, its collisions.
//
//   watching - the whole order of zones reached -> finished; it keeps counting
//
// The feet are four discs at fixed places of the body, which do not swing: they are on a line also
// while a real dog would lift them over it. Metres in the place's frame, world time.
//
// A plain value: the scene, time and the body come in as arguments. Each call must get the scene
// with the same lines and zones.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

inline constexpr std::array<const char*, 4> kFeet{"left fore", "right fore", "left hind",
                                                  "right hind"};

// A foot on watched lines, from its first contact to its last.
struct LineTouch {
  std::size_t foot = 0;  // of kFeet
  std::size_t line = 0;  // the one it overlapped most, an index into Scene::lines
  Duration from{};
  Duration to{};
  double depth_m = 0;             // the deepest overlap: 0 beside the line
  Eigen::Vector2d where_m{0, 0};  // the middle of the foot then
  bool whole_foot = false;        // the foot was wholly on the line, or went over it
};

struct ZoneVisit {
  std::size_t zone = 0;  // an index into Scene::zones
  Duration at{};
};

// The robot, as the referee sees it.
struct RobotSeen {
  Pose2 pose;
  bool lies = false;
  bool in_the_air = false;
};

class Referee {
 public:
  // The robot at the beginning.
  Referee(const Scene& scene, const RobotSeen& robot);

  // After each step of the world.
  void Step(const Scene& scene, const RobotSeen& robot, Duration now);
  void Collide() { ++collisions_; }
  // The robot was moved by hand to where it is now.
  void Carry(const Scene& scene, const RobotSeen& robot, Duration now);

  const std::vector<ZoneVisit>& visits() const { return visits_; }
  // By their beginning; the first 1000, the counts include all.
  const std::vector<LineTouch>& touches() const { return touches_; }
  std::size_t touch_count() const { return touch_count_; }
  std::size_t whole_foot_count() const { return whole_foot_count_; }
  std::size_t collisions() const { return collisions_; }
  std::size_t carried() const { return carried_; }
  std::optional<Duration> began() const { return began_; }  // it first moved
  // All zones of the order were reached, in this order.
  std::optional<Duration> finished() const { return finished_; }

 private:
  struct Foot {
    std::optional<std::size_t> touch;  // the present one, an index into touches_
    bool on_line = false;
    bool whole_foot = false;
  };

  void FindZones(const Scene& scene, const RobotSeen& robot, Duration now);
  void FindLines(const Scene& scene, const RobotSeen& robot, Duration now);
  void Keep(std::size_t foot, const LineTouch& touch);

  Eigen::Vector2d start_m_;
  std::vector<bool> inside_;  // of each zone
  std::vector<ZoneVisit> visits_;
  std::size_t reached_ = 0;  // zones of the order
  std::array<Foot, kFeet.size()> feet_;
  std::vector<LineTouch> touches_;
  std::size_t touch_count_ = 0;
  std::size_t whole_foot_count_ = 0;
  std::size_t collisions_ = 0;
  std::size_t carried_ = 0;
  std::optional<Duration> began_;
  std::optional<Duration> finished_;
};

// The position of a foot in the place.
Eigen::Vector2d FootOf(const RefereeSpec& spec, const Pose2& pose, std::size_t foot);

// Whether the robot is in the zone in the way that the zone demands.
bool IsReached(const Zone& zone, const RefereeSpec& spec, const RobotSeen& robot);

}  // namespace musher::world
