#pragma once
// What the nodes of nav2 use of a robot: where it is, what was requested of it by topics, and its
// tasks. A program implements it for its robot (for ours: modules/skills/nav2/tree_robot.hpp), a
// test by a fake.
//
//   task     Poll(now) in each tick ──→ nothing yet | its end. A task that is destroyed before its
//            end is cancelled.
//
// Poses are in the frame of the map. Every call returns at once.
//
// Threads: that of the tree.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "musher/base/time.hpp"
#include "musher/behavior/tree/nav2/geometry.hpp"

namespace musher::tree::nav2 {

// Codes of nav2's actions. 0: it has succeeded.
inline constexpr std::uint16_t kNoError = 0;
inline constexpr std::uint16_t kPlannerUnknown = 200;
inline constexpr std::uint16_t kPlannerTimeout = 207;
inline constexpr std::uint16_t kNoValidPath = 208;
inline constexpr std::uint16_t kControllerUnknown = 100;
inline constexpr std::uint16_t kPatienceExceeded = 104;
inline constexpr std::uint16_t kFailedToMakeProgress = 105;
inline constexpr std::uint16_t kNoValidControl = 106;

struct TaskEnd {
  bool success = false;
  std::uint16_t error_code = kNoError;
  std::string error{};  // why it has failed
  Path path{};          // of ComputePath()
};

class Task {
 public:
  Task() = default;
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;
  virtual ~Task() = default;
  // Nullopt: it goes on.
  virtual std::optional<TaskEnd> Poll(Time now) = 0;
};

class Robot {
 public:
  virtual ~Robot() = default;

  // Nullopt: not known.
  virtual std::optional<Pose> pose() const = 0;
  virtual double speed_m_s() const = 0;
  // The tolerance of GoalReached.
  virtual double goal_tolerance_m() const { return 0.25; }

  // The last goals that have come on the topics of GoalUpdater. Nullopt: none.
  virtual std::optional<Pose> goal_update() const { return std::nullopt; }
  virtual std::optional<Goals> goals_update() const { return std::nullopt; }
  // What was selected by the topic of a selector (PlannerSelector, ...). Empty: nothing.
  virtual std::string Selected(std::string_view /*topic*/) const { return ""; }

  // From `start`, or from where the robot is.
  virtual std::unique_ptr<Task> ComputePath(const Pose& goal, const std::optional<Pose>& start,
                                            const std::string& planner) = 0;
  // Replaces the path of a task that has not ended, without a stop.
  virtual std::unique_ptr<Task> FollowPath(const Path& path, const std::string& controller) = 0;
  // To the left; negative: to the right. It fails after `limit`.
  virtual std::unique_ptr<Task> Spin(double angle_rad, Duration limit) = 0;
  // Straight ahead; negative: backwards. It fails after `limit`.
  virtual std::unique_ptr<Task> Drive(double distance_m, double speed_m_s, Duration limit) = 0;
  // The service of a costmap, as the tree names it.
  virtual std::unique_ptr<Task> ClearCostmap(const std::string& service) = 0;
};

}  // namespace musher::tree::nav2
