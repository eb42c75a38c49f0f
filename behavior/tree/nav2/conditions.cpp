// The conditions of nav2 that need no server.

#include <algorithm>
#include <array>
#include <cmath>

#include "musher/behavior/tree/nav2/checked.hpp"
#include "musher/behavior/tree/nav2/goal_watch.hpp"
#include "musher/behavior/tree/nav2/recent_tick.hpp"
#include "musher/behavior/tree/nav2/register.hpp"

namespace musher::tree::nav2 {
namespace {

void IgnoreFramesOf(Setup& setup) {
  static_cast<void>(setup.OptionalInput<std::string>("global_frame", "ignored: the map"));
  static_cast<void>(setup.OptionalInput<std::string>("robot_base_frame", "ignored: the robot"));
}

// A change before it begins does not count.
class GoalUpdated : public Condition {
 public:
  explicit GoalUpdated(Setup& setup) : goals_(setup) {}

 private:
  Status Evaluate(const Tick& tick) override {
    const bool begins = recent_.Begins(tick, status());
    const bool has_changed = goals_.HasChanged();
    return StatusOf(has_changed && !begins);
  }

  GoalWatch goals_;
  RecentTick recent_;
};

// Since its last tick; the first goal counts.
class GlobalUpdatedGoal : public Condition {
 public:
  explicit GlobalUpdatedGoal(Setup& setup) : goals_(setup) {}

 private:
  Status Evaluate(const Tick&) override {
    const bool is_first = !ticked_;
    ticked_ = true;
    return StatusOf(goals_.HasChanged() || is_first);
  }

  GoalWatch goals_;
  bool ticked_ = false;
};

class GoalReached : public Condition {
 public:
  GoalReached(Setup& setup, const Robot& robot)
      : goal_(setup.Input<Pose>("goal", "the goal")), robot_(robot) {
    IgnoreFramesOf(setup);
  }

 private:
  Status Evaluate(const Tick&) override {
    const std::optional<Pose> pose = robot_.pose();
    const Pose& goal = goal_.Get();
    return StatusOf(pose && Apart(robot_, goal, *pose) <= robot_.goal_tolerance_m(goal));
  }

  InPort<Pose> goal_;
  const Robot& robot_;
};

class DistanceTraveled : public Condition {
 public:
  DistanceTraveled(Setup& setup, const Robot& robot)
      : distance_m_(setup.Input<double>("distance", 1.0, "m")), robot_(robot) {
    IgnoreFramesOf(setup);
  }

 private:
  Status Evaluate(const Tick& tick) override {
    const double distance_m = Checked(distance_m_);
    const std::optional<Pose> pose = robot_.pose();
    if (recent_.Begins(tick, status())) begin_.reset();
    if (!pose) return Status::kFailure;
    if (!begin_) begin_ = *pose;
    if (Apart(robot_, *begin_, *pose) < distance_m) return Status::kFailure;
    begin_ = *pose;
    return Status::kSuccess;
  }

  InPort<double> distance_m_;
  const Robot& robot_;
  RecentTick recent_;
  std::optional<Pose> begin_;
};

class TimeExpired : public Condition {
 public:
  explicit TimeExpired(Setup& setup) : seconds_(setup.Input<double>("seconds", 1.0, "s")) {}

 private:
  Status Evaluate(const Tick& tick) override {
    const double seconds = Checked(seconds_);
    const bool begins = recent_.Begins(tick, status());
    if (begins) begin_ = tick.now;
    if (begins || ToSeconds(tick.now - begin_) < seconds) return Status::kFailure;
    begin_ = tick.now;
    return Status::kSuccess;
  }

  InPort<double> seconds_;
  RecentTick recent_;
  Time begin_{};
};

// Since the path has changed, or the run of the tree began.
class PathExpiringTimer : public Condition, public RunObserver {
 public:
  explicit PathExpiringTimer(Setup& setup)
      : seconds_(setup.Input<double>("seconds", 1.0, "s")),
        path_(setup.OptionalInput<Path>("path", "a new one begins the time again")) {}

 private:
  void OnNewRun(const Tick&) override { begin_.reset(); }
  Status Evaluate(const Tick& tick) override {
    const double seconds = Checked(seconds_);
    const Path* path = path_.Find();
    const bool begins = !begin_ || (path != nullptr && *path != before_);
    if (begins) {
      begin_ = tick.now;
      before_ = path != nullptr ? *path : Path{};
    }
    if (begins || ToSeconds(tick.now - *begin_) < seconds) return Status::kFailure;
    begin_ = tick.now;
    return Status::kSuccess;
  }

  InPort<double> seconds_;
  InPort<Path> path_;
  std::optional<Time> begin_;
  Path before_;
};

class InitialPoseReceived : public Condition {
 public:
  explicit InitialPoseReceived(Setup& setup)
      : received_(setup.Input<bool>("initial_pose_received", FromEntry{"="},
                                    "the entry that is true once there was one")) {}

 private:
  Status Evaluate(const Tick&) override { return StatusOf(received_.Or(false)); }

  InPort<bool> received_;
};

class ArePosesNear : public Condition {
 public:
  ArePosesNear(Setup& setup, const Robot& robot)
      : reference_(setup.Input<Pose>("ref_pose", "a pose")),
        target_(setup.Input<Pose>("target_pose", "another one")),
        tolerance_m_(setup.Input<double>("tolerance", 0.5, "m")),
        robot_(robot) {
    IgnoreFramesOf(setup);
  }

 private:
  Status Evaluate(const Tick&) override {
    return StatusOf(Apart(robot_, reference_.Get(), target_.Get()) <= Checked(tolerance_m_));
  }

  InPort<Pose> reference_;
  InPort<Pose> target_;
  InPort<double> tolerance_m_;
  const Robot& robot_;
};

// A robot that does not drive is within them.
class IsWithinPathTrackingBounds : public Condition {
 public:
  explicit IsWithinPathTrackingBounds(Setup& setup)
      : left_m_(setup.Input<double>("max_error_left", 0.5, "m to the left of the path")),
        right_m_(setup.Input<double>("max_error_right", 0.5, "m to the right of the path")),
        heading_rad_(setup.Input<double>("max_error_heading", 3.14, "rad to either side")),
        tracking_(setup.OptionalInput<Tracking>("tracking_feedback", "that of FollowPath")) {}

 private:
  Status Evaluate(const Tick&) override {
    const double left_m = Limit(left_m_), right_m = Limit(right_m_);
    const double heading_rad = Limit(heading_rad_);
    const Tracking* tracking = tracking_.Find();
    if (tracking == nullptr) return Status::kSuccess;
    return StatusOf(tracking->off_m <= left_m && tracking->off_m >= -right_m &&
                    std::abs(tracking->heading_rad) <= heading_rad);
  }
  // As in nav2 its sign does not count.
  static double Limit(const InPort<double>& port) {
    const double limit = std::abs(port.Get());
    if (std::isnan(limit)) throw PortError("port '" + port.name() + "' has to be a number");
    return limit;
  }

  InPort<double> left_m_;
  InPort<double> right_m_;
  InPort<double> heading_rad_;
  InPort<Tracking> tracking_;
};

// One of the given codes, which are those of an action.
class AreErrorCodesPresent : public Condition {
 public:
  explicit AreErrorCodesPresent(Setup& setup)
      : AreErrorCodesPresent(
            setup, setup.OptionalInput<std::vector<int>>("error_codes_to_check", "the codes"), {}) {
  }
  AreErrorCodesPresent(Setup& setup, InPort<std::vector<int>> codes, std::vector<int> fixed)
      : code_(setup.OptionalInput<std::uint16_t>("error_code", "of an action; 0: none")),
        codes_(std::move(codes)),
        fixed_(std::move(fixed)) {}

 private:
  Status Evaluate(const Tick&) override {
    const std::uint16_t* code = code_.Find();
    if (code == nullptr) return Status::kFailure;
    const std::vector<int>* given = codes_.Find();
    const std::vector<int>& codes = given != nullptr ? *given : fixed_;
    return StatusOf(std::ranges::find(codes, int{*code}) != codes.end());
  }

  InPort<std::uint16_t> code_;
  InPort<std::vector<int>> codes_;
  std::vector<int> fixed_;
};

struct KnownCodes {
  std::string_view node;
  std::string_view does;
  std::vector<int> codes;
};

// Codes of nav2_msgs after which another attempt may help.
const std::vector<KnownCodes>& CodesToRecoverFrom() {
  static const std::vector<KnownCodes> codes = {
      {"WouldAPlannerRecoveryHelp",
       "SUCCESS where the planner has failed with UNKNOWN, TIMEOUT or NO_VALID_PATH, also of "
       "ComputePathThroughPoses.",
       {kPlannerUnknown, kPlannerTimeout, kNoValidPath, kPlacesUnknown, kPlacesTimeout,
        kNoValidPathThroughPlaces}},
      {"WouldAControllerRecoveryHelp",
       "SUCCESS where the controller has failed with UNKNOWN, PATIENCE_EXCEEDED, "
       "FAILED_TO_MAKE_PROGRESS or NO_VALID_CONTROL.",
       {kControllerUnknown, kPatienceExceeded, kFailedToMakeProgress, kNoValidControl}},
      {"WouldARouteRecoveryHelp",
       "SUCCESS where the route server has failed with UNKNOWN, TIMEOUT or NO_VALID_ROUTE.",
       {kRouteUnknown, kRouteTimeout, kNoValidRoute}},
      {"WouldASmootherRecoveryHelp",
       "SUCCESS where the smoother has failed with UNKNOWN, TIMEOUT, FAILED_TO_SMOOTH_PATH or "
       "SMOOTHED_PATH_IN_COLLISION.",
       {kSmootherUnknown, kSmootherTimeout, kFailedToSmooth, kSmoothedPathInCollision}},
  };
  return codes;
}

}  // namespace

void AddConditionNodes(Factory& factory, Robot& robot) {
  constexpr NodeKind kKind = NodeKind::kCondition;
  AddNode<GoalUpdated>(factory, "GoalUpdated", kKind, false,
                       "SUCCESS in the tick in which the goal has changed.");
  AddNode<GlobalUpdatedGoal>(factory, "GlobalUpdatedGoal", kKind, false,
                             "SUCCESS where the goal has changed since its last tick, also across "
                             "halts.");
  AddNode<GoalReached>(factory, "GoalReached", kKind, false,
                       "SUCCESS where the robot is at the goal, within 0.25 m; robots of "
                       "musher-skills also where their drive has arrived at this goal.",
                       robot);
  AddNode<DistanceTraveled>(factory, "DistanceTraveled", kKind, false,
                            "SUCCESS each time the robot has travelled so far.", robot);
  AddNode<TimeExpired>(factory, "TimeExpired", kKind, false,
                       "SUCCESS each time so many seconds have passed.");
  AddNode<PathExpiringTimer>(factory, "PathExpiringTimer", kKind, false,
                             "SUCCESS each time the path is so old.");
  AddNode<InitialPoseReceived>(factory, "InitialPoseReceived", kKind, false,
                               "SUCCESS where the entry is true.");
  AddNode<ArePosesNear>(factory, "ArePosesNear", kKind, false,
                        "SUCCESS where two poses are near each other.", robot);
  AddNode<IsWithinPathTrackingBounds>(factory, "IsWithinPathTrackingBounds", kKind, false,
                                      "SUCCESS where a drive is near its path, and where there is "
                                      "none.");
  AddNode<AreErrorCodesPresent>(factory, "AreErrorCodesPresent", kKind, false,
                                "SUCCESS where the code of an action is one of these.");
  for (const KnownCodes& known : CodesToRecoverFrom()) {
    if (factory.Find(known.node) != nullptr) continue;
    static_cast<void>(factory.Register(
        known.node, {.kind = kKind,
                     .make = [&known](Setup& setup) -> std::unique_ptr<Node> {
                       return std::make_unique<AreErrorCodesPresent>(
                           setup,
                           setup.OptionalInput<std::vector<int>>(
                               "error_codes_to_check", "other codes than those of the node"),
                           known.codes);
                     },
                     .description = std::string(known.does)}));
  }
}

}  // namespace musher::tree::nav2
