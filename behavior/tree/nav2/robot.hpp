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

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/behavior/tree/nav2/geometry.hpp"

namespace musher::tree::nav2 {

// Codes of nav2's actions. 0: it has succeeded.
inline constexpr std::uint16_t kNoError = 0;
inline constexpr std::uint16_t kServiceFailed = 1;  // of ClearEntireCostmap, which has none in nav2
inline constexpr std::uint16_t kControllerUnknown = 100;
inline constexpr std::uint16_t kInvalidController = 101;
inline constexpr std::uint16_t kControllerPose = 102;
inline constexpr std::uint16_t kInvalidPath = 103;
inline constexpr std::uint16_t kPatienceExceeded = 104;
inline constexpr std::uint16_t kFailedToMakeProgress = 105;
inline constexpr std::uint16_t kNoValidControl = 106;
inline constexpr std::uint16_t kControllerTimeout = 107;
inline constexpr std::uint16_t kDriveCancelled = 150;  // by another client; nav2 has no code
inline constexpr std::uint16_t kPlannerUnknown = 200;
inline constexpr std::uint16_t kInvalidPlanner = 201;
inline constexpr std::uint16_t kPlannerPose = 202;
inline constexpr std::uint16_t kStartOutside = 203;
inline constexpr std::uint16_t kGoalOutside = 204;
inline constexpr std::uint16_t kStartOccupied = 205;
inline constexpr std::uint16_t kGoalOccupied = 206;
inline constexpr std::uint16_t kPlannerTimeout = 207;
inline constexpr std::uint16_t kNoValidPath = 208;
inline constexpr std::uint16_t kPlacesUnknown = 300;  // of ComputePathThroughPoses: those of the
inline constexpr std::uint16_t kPlacesTimeout = 307;  // planner + 100, and kNoPlacesGiven
inline constexpr std::uint16_t kNoValidPathThroughPlaces = 308;
inline constexpr std::uint16_t kNoPlacesGiven = 309;
inline constexpr std::uint16_t kRouteUnknown = 400;  // of ComputeRoute and ComputeAndTrackRoute
inline constexpr std::uint16_t kRoutePose = 401;
inline constexpr std::uint16_t kNoValidGraph = 402;
inline constexpr std::uint16_t kNotOnGraph = 403;
inline constexpr std::uint16_t kRouteTimeout = 404;
inline constexpr std::uint16_t kNoValidRoute = 405;
inline constexpr std::uint16_t kSmootherUnknown = 500;
inline constexpr std::uint16_t kInvalidSmoother = 501;
inline constexpr std::uint16_t kSmootherTimeout = 502;
inline constexpr std::uint16_t kSmoothedPathInCollision = 503;
inline constexpr std::uint16_t kFailedToSmooth = 504;
inline constexpr std::uint16_t kPathToSmoothInvalid = 505;
inline constexpr std::uint16_t kSpinUnknown = 700;
inline constexpr std::uint16_t kSpinTimeout = 701;
inline constexpr std::uint16_t kSpinPose = 702;
inline constexpr std::uint16_t kSpinCollision = 703;
inline constexpr std::uint16_t kBackUpUnknown = 710;
inline constexpr std::uint16_t kBackUpTimeout = 711;
inline constexpr std::uint16_t kBackUpPose = 712;
inline constexpr std::uint16_t kBackUpInvalidInput = 713;
inline constexpr std::uint16_t kBackUpCollision = 714;
inline constexpr std::uint16_t kDriveUnknown = 720;
inline constexpr std::uint16_t kDriveTimeout = 721;
inline constexpr std::uint16_t kDrivePose = 722;
inline constexpr std::uint16_t kDriveCollision = 723;
inline constexpr std::uint16_t kDriveInvalidInput = 724;
inline constexpr std::uint16_t kTeleopUnknown = 730;
inline constexpr std::uint16_t kTeleopTimeout = 731;
inline constexpr std::uint16_t kWaitUnknown = 740;
inline constexpr std::uint16_t kFollowUnknown = 1000;    // of FollowObject, any failure
inline constexpr std::uint16_t kNavigateUnknown = 9000;  // of NavigateToPose
inline constexpr std::uint16_t kNavigateThroughUnknown = 9100;

struct TaskEnd {
  bool success = false;
  std::uint16_t error_code = kNoError;  // of a failure: 0 becomes UNKNOWN of the action
  std::string error{};                  // why it has failed
  Path path{};                          // of ComputePath(), ComputeRoute() and SmoothPath()
  Route route{};                        // of ComputeRoute()
  std::vector<bool> occupied{};         // of CheckPlaces(): each of them
};

// Where a route begins and ends.
struct RouteRequest {
  bool by_poses = false;        // false: by the ids of nodes
  std::optional<Pose> start{};  // nullopt: where the robot is
  Pose goal{};
  std::uint16_t start_id = 0;
  std::uint16_t goal_id = 0;
};

// How far a robot is along a route.
struct RouteProgress {
  std::uint16_t last_node = 0;  // 0 also: none
  std::uint16_t next_node = 0;
  std::uint16_t edge = 0;
  Route route{};
  Path path{};                // along it
  bool rerouted = false;      // it is another route than in the report before
  std::uint64_t reports = 0;  // so far; 0: nothing is known yet
};

// Whether the robot could stand at places.
struct OccupancyRequest {
  Goals places{};
  bool whole_body = true;       // false: what is exactly at the place counts
  bool unknown_counts = false;  // what is not known counts as occupied
};

// How fast it is, in any direction.
struct Motion {
  double speed_m_s = 0;
  double turn_rad_s = 0;
};

struct Battery {
  std::optional<double> share{};  // 0 to 1; nullopt: not measured
  std::optional<double> voltage_v{};
  bool charges = false;
};

// Nodes that other nodes cancel, such as CancelSpin.
enum class Cancellable : std::uint8_t {
  kSpin,
  kBackUp,
  kDriveOnHeading,
  kWait,
  kAssistedTeleop,
  kFollowObject,
};

class Task {
 public:
  Task() = default;
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;
  virtual ~Task() = default;
  // Nullopt: it goes on.
  virtual std::optional<TaskEnd> Poll(Time now) = 0;
  // The progress of TrackRoute(). Null: this task tracks no route.
  virtual const RouteProgress* progress() const { return nullptr; }
};

class Robot {
 public:
  Robot() = default;
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;
  virtual ~Robot() = default;

  // Cancels the nodes of this kind that run now, of every tree of this robot: they end in their
  // next tick.
  void CancelNodes(Cancellable kind) { ++cancels_[static_cast<std::size_t>(kind)]; }
  // How often that was done.
  std::uint64_t cancels(Cancellable kind) const { return cancels_[static_cast<std::size_t>(kind)]; }

  // Nullopt: not known.
  virtual std::optional<Pose> pose() const = 0;
  virtual double speed_m_s() const = 0;
  // Nullopt: not known.
  virtual std::optional<Motion> motion() const { return std::nullopt; }
  // Whether a task, or another client, moves the base.
  virtual bool IsDriven() const { return false; }
  // The last report on this topic; empty: on that of the robot. Nullopt: none.
  virtual std::optional<Battery> battery(std::string_view /*topic*/) const { return std::nullopt; }
  virtual bool HasTransform(std::string_view /*parent*/, std::string_view /*child*/) const {
    return false;
  }
  // How often the service of PauseResumeController with this name was called.
  virtual std::uint64_t Calls(std::string_view /*service*/) const { return 0; }
  // On the ground the height of a place does not count.
  virtual bool flies() const { return false; }
  // The tolerance of GoalReached; it may be larger for a goal at which a drive has arrived.
  virtual double goal_tolerance_m(const Pose& /*goal*/) const { return 0.25; }

  // Whether FollowPath() uses the controller of that name; false: there is one.
  virtual bool selects_controllers() const { return true; }

  // How fast Spin() turns and Drive() moves at most, for the warning of a limit that is too short.
  virtual double most_turn_rad_s() const { return std::numeric_limits<double>::infinity(); }
  virtual double most_drive_m_s() const { return std::numeric_limits<double>::infinity(); }

  // The last goals that have come on the topics of GoalUpdater. Nullopt: none.
  virtual std::optional<Pose> goal_update() const { return std::nullopt; }
  virtual std::optional<Goals> goals_update() const { return std::nullopt; }
  // What was selected by the topic of a selector (PlannerSelector, ...). Empty: nothing.
  virtual std::string Selected(std::string_view /*topic*/) const { return ""; }

  // Whether the robot sees no obstacle on the rest of the path, and on the way to it. False also
  // where it does not see. The path has poses.
  virtual bool IsFree(const Path& /*path*/) const { return false; }
  // Has the controller cancel the drives that have begun until now, for any client. False: there is
  // no controller.
  virtual bool CancelDrives() { return false; }

  // A tree with a FollowPath begins a run.
  virtual void OnNewRun() {}

  // From `start`, or from where the robot is.
  virtual std::unique_ptr<Task> ComputePath(const Pose& goal, const std::optional<Pose>& start,
                                            const std::string& planner) = 0;
  // Whether the drive along `driven`, which goes on, is also that along `next`: it is not replaced.
  // Both have poses.
  virtual bool IsSameDrive(const Path& driven, const Path& next) const { return driven == next; }
  // Replaces the path of a task that has not ended, without a stop.
  virtual std::unique_ptr<Task> FollowPath(const Path& path, const std::string& controller) = 0;
  // To the left; negative: to the right. It fails after `limit`; 0: there is none.
  virtual std::unique_ptr<Task> Spin(double angle_rad, Duration limit) = 0;
  // Straight ahead; negative: backwards. It fails after `limit`; 0: there is none. Its codes are
  // those of DriveOnHeading; BackUp makes its own of them.
  virtual std::unique_ptr<Task> Drive(double distance_m, double speed_m_s, Duration limit) = 0;
  // A route over the graph of its route server, and the path along it.
  virtual std::unique_ptr<Task> ComputeRoute(const RouteRequest& /*request*/) { return nullptr; }
  // The same, and how far the robot is along it, until it is at its end. It moves nothing.
  virtual std::unique_ptr<Task> TrackRoute(const RouteRequest& /*request*/) { return nullptr; }
  // Has the route server cancel the routes that it tracks now, for any client. False: there is no
  // route server.
  virtual bool CancelRoutes() { return false; }
  // A path without sharp corners. With `check` it fails where the robot sees something on it.
  virtual std::unique_ptr<Task> SmoothPath(const Path& /*path*/, const std::string& /*smoother*/,
                                           bool /*check*/) {
    return nullptr;
  }
  // The service of a costmap, as the tree names it.
  virtual std::unique_ptr<Task> ClearCostmap(const std::string& service) = 0;
  // Whether each of the places is occupied.
  virtual std::unique_ptr<Task> CheckPlaces(const OccupancyRequest& /*request*/) { return nullptr; }
  // To each of the places, one after the other, with the recoveries of the robot.
  virtual std::unique_ptr<Task> Navigate(const Goals& /*places*/) { return nullptr; }
  // Keeps a distance from what reports its pose on this topic; 0: without a limit.
  virtual std::unique_ptr<Task> FollowObject(const std::string& /*topic*/, Duration /*limit*/) {
    return nullptr;
  }
  // Leaves the base to a person. It fails with kTeleopTimeout after `limit`; 0: there is none.
  virtual std::unique_ptr<Task> Teleoperate(Duration /*limit*/) { return nullptr; }

 private:
  std::array<std::uint64_t, 6> cancels_{};
};

// How far two places are from each other for this robot.
inline double Apart(const Robot& robot, const Pose& a, const Pose& b) {
  return robot.flies() ? Distance(a, b) : std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

}  // namespace musher::tree::nav2
