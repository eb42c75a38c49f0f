// The actions of nav2 that a robot of ours has: tasks of robot.hpp, Wait, and the selectors.

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/behavior/tree/nav2/checked.hpp"
#include "musher/behavior/tree/nav2/path_places.hpp"
#include "musher/behavior/tree/nav2/register.hpp"
#include "musher/behavior/tree/nav2/task_node.hpp"

namespace musher::tree::nav2 {
namespace {

class ComputePathToPose : public TaskNode {
 public:
  ComputePathToPose(Setup& setup, Robot& robot)
      : TaskNode(setup, kPlannerUnknown),
        goal_(setup.Input<Pose>("goal", "where to")),
        start_(setup.OptionalInput<Pose>("start", "where from; else from where the robot is")),
        uses_start_(setup.OptionalInput<bool>("use_start", "false: `start` does not count")),
        planner_(setup.OptionalInput<std::string>("planner_id", "name of a planner")),
        path_(setup.Output<Path>("path", "the path; empty after a failure or a halt")),
        robot_(robot) {}

 private:
  std::unique_ptr<Task> Begin() override {
    std::optional<Pose> start;
    if (start_.Find() != nullptr && uses_start_.Or(true)) start = *start_.Find();
    return robot_.ComputePath(goal_.Get(), start, planner_.Or(""));
  }
  void OnEnd(const TaskEnd& end) override { path_.Set(end.success ? end.path : Path{}); }

  InPort<Pose> goal_;
  InPort<Pose> start_;
  InPort<bool> uses_start_;
  InPort<std::string> planner_;
  OutPort<Path> path_;
  Robot& robot_;
};

// A path through places: a path to each, one after the other.
class ComputePathThroughPoses : public TaskNode {
 public:
  ComputePathThroughPoses(Setup& setup, Robot& robot)
      : TaskNode(setup, kPlacesUnknown),
        goals_(setup.Input<Goals>("goals", "the places, in their order")),
        start_(setup.OptionalInput<Pose>("start", "where from; else from where the robot is")),
        planner_(setup.OptionalInput<std::string>("planner_id", "name of a planner")),
        path_(setup.Output<Path>("path", "the path; empty after a failure or a halt")),
        robot_(robot) {
    static_cast<void>(
        setup.Connect({"last_reached_index", Direction::kOut, nullptr, false, "is not set"}));
  }

 private:
  class PartByPart : public Task {
   public:
    PartByPart(Robot& robot, std::vector<Pose> places, std::optional<Pose> start,
               std::string planner)
        : robot_(robot),
          places_(std::move(places)),
          start_(std::move(start)),
          planner_(std::move(planner)) {}

    std::optional<TaskEnd> Poll(Time now) override {
      if (places_.empty()) return TaskEnd{.error_code = kNoPlacesGiven, .error = "no places"};
      while (next_ < places_.size()) {
        if (part_ == nullptr) part_ = robot_.ComputePath(places_[next_], start_, planner_);
        if (part_ == nullptr) return TaskEnd{.error = "the robot does not have this action"};
        std::optional<TaskEnd> end = part_->Poll(now);
        if (!end) return std::nullopt;
        part_.reset();
        if (!end->success) return FailureOf(std::move(*end));
        Append(end->path);
        start_ = places_[next_++];
      }
      return TaskEnd{.success = true, .path = std::move(path_)};
    }

   private:
    // A part begins where the one before has ended.
    void Append(const Path& part) {
      if (part.poses.empty()) return;
      const bool same =
          !path_.poses.empty() && Distance(path_.poses.back(), part.poses.front()) == 0;
      path_.poses.insert(path_.poses.end(), part.poses.begin() + (same ? 1 : 0), part.poses.end());
    }
    TaskEnd FailureOf(TaskEnd end) const {
      if (end.error_code != kNoError) {
        constexpr int kFurther = kPlacesUnknown - kPlannerUnknown;
        end.error_code = static_cast<std::uint16_t>(end.error_code + kFurther);
      }
      end.error = "place " + std::to_string(next_ + 1) + " of " + std::to_string(places_.size()) +
                  ": " + end.error;
      return end;
    }

    Robot& robot_;
    const std::vector<Pose> places_;
    std::optional<Pose> start_;  // of the next part
    const std::string planner_;
    std::size_t next_ = 0;
    std::unique_ptr<Task> part_;
    Path path_;
  };

  std::unique_ptr<Task> Begin() override {
    std::optional<Pose> start;
    if (start_.Find() != nullptr) start = *start_.Find();
    return std::make_unique<PartByPart>(robot_, goals_.Get().poses, start, planner_.Or(""));
  }
  void OnEnd(const TaskEnd& end) override { path_.Set(end.success ? end.path : Path{}); }

  InPort<Goals> goals_;
  InPort<Pose> start_;
  InPort<std::string> planner_;
  OutPort<Path> path_;
  Robot& robot_;
};

// A path that changes while it is followed is followed from then on, also by another controller.
class FollowPath : public TaskNode {
 public:
  FollowPath(Setup& setup, Robot& robot)
      : TaskNode(setup, kControllerUnknown),
        path_(setup.Input<Path>("path", "the path")),
        controller_(setup.OptionalInput<std::string>("controller_id", "name of a controller")),
        tracking_(setup.Output<Tracking>("tracking_feedback",
                                         "how well it keeps to the path, while it drives")),
        robot_(robot) {
    for (const char* port : {"goal_checker_id", "progress_checker_id", "path_handler_id"}) {
      static_cast<void>(setup.OptionalInput<std::string>(port, "ignored"));
    }
  }

 private:
  std::unique_ptr<Task> Begin() override {
    if (!running()) {
      seen_ = path_.entry()->sequence;
      followed_ = path_.Get();
    }
    followed_by_ = controller_.Or("");
    searches_all_ = true;
    Track();
    return robot_.FollowPath(followed_, followed_by_);
  }
  void OnNewRun(const Tick& tick) override {
    TaskNode::OnNewRun(tick);
    robot_.OnNewRun();
  }
  // Nothing is known of a drive that is over.
  void OnEnd(const TaskEnd& /*end*/) override { tracking_.Set({}); }
  // A path may cross itself: from its place on a path on the robot is sought near the last one.
  void Track() {
    constexpr double kSearchM = 2;
    const std::optional<Pose> pose = tracking_.connected() ? robot_.pose() : std::nullopt;
    if (!pose || followed_.poses.empty()) return;
    const double search_m = std::exchange(searches_all_, false) ? PathProgress::kNoLimit : kSearchM;
    const double along_m = progress_.Along(robot_, followed_, *pose, search_m);
    tracking_.Set(TrackingAt(followed_, *pose, along_m));
  }
  // A failure to compute another path leaves the entry empty: the path before still counts.
  Status OnRunning(const Tick& tick) override {
    bool replaces = robot_.selects_controllers() && controller_.Or("") != followed_by_;
    if (path_.entry()->sequence != seen_) {
      seen_ = path_.entry()->sequence;
      const Path& path = path_.Get();
      if (!path.poses.empty() && !robot_.IsSameDrive(followed_, path)) {
        followed_ = path;
        replaces = true;
      }
    }
    if (replaces) {
      Replace();
    } else {
      Track();
    }
    return Poll(tick.now);
  }

  InPort<Path> path_;
  InPort<std::string> controller_;
  OutPort<Tracking> tracking_;
  Robot& robot_;
  Path followed_;
  PathProgress progress_;  // along it
  bool searches_all_ = true;
  std::string followed_by_;
  std::uint64_t seen_ = 0;  // of the entry
};

// The amount of a motion, in m or rad.
double AmountOf(const InPort<double>& port) {
  constexpr double kMost = 100;
  const double amount = port.Get();
  if (!(std::abs(amount) <= kMost)) {
    throw PortError("port '" + port.name() + "' has to be from -100 to 100");
  }
  return amount;
}

InPort<double> LimitPort(Setup& setup) {
  return setup.Input<double>("time_allowance", 10.0, "s; it fails after that; 0: no limit");
}

// A limit that ends each such motion before its end.
void WarnOfLimit(Setup& setup, const InPort<double>& limit_s, double least_s) {
  if (limit_s.entry() != nullptr || limit_s.Find() == nullptr) return;
  if (!(*limit_s.Find() > 0 && least_s > *limit_s.Find())) return;
  setup.Report("time_allowance", Severity::kWarning,
               setup.name() + " takes " + NumberText(std::ceil(10 * least_s) / 10) +
                   " s on this robot, and fails after " + NumberText(*limit_s.Find()) + " s");
}

// The fixed number of a port; 0: an entry.
double FixedOf(const InPort<double>& port) {
  const double* fixed = port.entry() == nullptr ? port.Find() : nullptr;
  return fixed != nullptr ? std::abs(*fixed) : 0;
}

class Spin : public TaskNode {
 public:
  Spin(Setup& setup, Robot& robot)
      : TaskNode(setup, kSpinUnknown),
        angle_rad_(setup.Input<double>("spin_dist", 1.57, "rad, to the left")),
        limit_s_(LimitPort(setup)),
        robot_(robot) {
    EndsBy(robot, Cancellable::kSpin);
    WarnOfLimit(setup, limit_s_, FixedOf(angle_rad_) / robot.most_turn_rad_s());
    static_cast<void>(setup.OptionalInput<bool>("is_recovery", "ignored"));
    static_cast<void>(
        setup.OptionalInput<bool>("disable_collision_checks", "ignored: it is always checked"));
  }

 private:
  std::unique_ptr<Task> Begin() override {
    return robot_.Spin(AmountOf(angle_rad_), LimitOf(limit_s_));
  }

  InPort<double> angle_rad_;
  InPort<double> limit_s_;
  Robot& robot_;
};

// BackUp and DriveOnHeading.
class StraightDrive : public TaskNode {
 public:
  StraightDrive(Setup& setup, Robot& robot, bool backwards)
      : TaskNode(setup, backwards ? kBackUpUnknown : kDriveUnknown),
        distance_m_(setup.Input<double>(backwards ? "backup_dist" : "dist_to_travel", 0.15, "m")),
        speed_m_s_(setup.Input<double>(backwards ? "backup_speed" : "speed", 0.025, "m/s")),
        limit_s_(LimitPort(setup)),
        robot_(robot),
        backwards_(backwards) {
    EndsBy(robot, backwards ? Cancellable::kBackUp : Cancellable::kDriveOnHeading);
    const double speed_m_s = std::min(FixedOf(speed_m_s_), robot.most_drive_m_s());
    if (speed_m_s > 0) WarnOfLimit(setup, limit_s_, FixedOf(distance_m_) / speed_m_s);
    static_cast<void>(
        setup.OptionalInput<bool>("disable_collision_checks", "ignored: it is always checked"));
  }

 private:
  class Refused : public Task {
    std::optional<TaskEnd> Poll(Time /*now*/) override {
      return TaskEnd{.error_code = kDriveInvalidInput,
                     .error = "its distance and its speed differ in their signs"};
    }
  };

  // The signs of BackUp mean nothing: nav2's own trees have both.
  std::unique_ptr<Task> Begin() override {
    const double distance_m = AmountOf(distance_m_);
    const double speed_m_s = AmountOf(speed_m_s_);
    const Duration limit = LimitOf(limit_s_);
    if (!backwards_ && (distance_m > 0) != (speed_m_s > 0)) return std::make_unique<Refused>();
    return robot_.Drive(backwards_ ? -std::abs(distance_m) : distance_m, std::abs(speed_m_s),
                        limit);
  }
  std::uint16_t CodeOf(const TaskEnd& end) const override {
    if (!backwards_) return end.error_code;
    switch (end.error_code) {
      case kDriveTimeout:
        return kBackUpTimeout;
      case kDrivePose:
        return kBackUpPose;
      case kDriveCollision:
        return kBackUpCollision;
      case kDriveInvalidInput:
        return kBackUpInvalidInput;
      default:
        return kBackUpUnknown;
    }
  }

  InPort<double> distance_m_;
  InPort<double> speed_m_s_;
  InPort<double> limit_s_;
  Robot& robot_;
  const bool backwards_;
};

class CancelControl : public Action {
 public:
  CancelControl(Setup& setup, Robot& robot) : robot_(robot) {
    static_cast<void>(setup.OptionalInput<std::string>("server_name", "ignored"));
    static_cast<void>(setup.OptionalInput<double>("server_timeout", "ignored: ms"));
  }

 private:
  Status Do(const Tick&) override {
    return robot_.CancelDrives() ? Status::kSuccess : Status::kFailure;
  }

  Robot& robot_;
};

class ClearEntireCostmap : public TaskNode {
 public:
  ClearEntireCostmap(Setup& setup, Robot& robot)
      : TaskNode(setup, kServiceFailed),
        service_(setup.OptionalInput<std::string>("service_name", "which costmap")),
        robot_(robot) {}

 private:
  std::unique_ptr<Task> Begin() override { return robot_.ClearCostmap(service_.Or("")); }

  InPort<std::string> service_;
  Robot& robot_;
};

class Wait : public TaskNode {
 public:
  Wait(Setup& setup, Robot& robot)
      : TaskNode(setup, kWaitUnknown), duration_s_(setup.Input<double>("wait_duration", 1.0, "s")) {
    EndsBy(robot, Cancellable::kWait);
  }

 private:
  class Timer : public Task {
   public:
    explicit Timer(Duration duration) : duration_(duration) {}
    std::optional<TaskEnd> Poll(Time now) override {
      if (!begin_) begin_ = now;
      if (now - *begin_ < duration_) return std::nullopt;
      return TaskEnd{.success = true};
    }

   private:
    const Duration duration_;
    std::optional<Time> begin_;
  };

  std::unique_ptr<Task> Begin() override { return std::make_unique<Timer>(LimitOf(duration_s_)); }

  InPort<double> duration_s_;
};

// PlannerSelector, ...: what a topic has selected, or else the default.
class Selector : public Action {
 public:
  Selector(Setup& setup, const Robot& robot, const std::string& of)
      : default_(setup.OptionalInput<std::string>("default_" + of, "until one is selected")),
        topic_(setup.OptionalInput<std::string>("topic_name", "where one is selected")),
        selected_(setup.Output<std::string>("selected_" + of, "the one that is selected")),
        robot_(robot),
        topic_of_kind_(of + "_selector") {}

 private:
  Status Do(const Tick&) override {
    const std::string* topic = topic_.Find();
    std::string name = robot_.Selected(topic != nullptr ? *topic : topic_of_kind_);
    if (name.empty()) name = default_.Or("");
    if (name.empty()) return Status::kFailure;
    selected_.Set(name);
    return Status::kSuccess;
  }

  InPort<std::string> default_;
  InPort<std::string> topic_;
  OutPort<std::string> selected_;
  const Robot& robot_;
  const std::string topic_of_kind_;
};

void AddSelector(Factory& factory, Robot& robot, std::string_view name, const std::string& of) {
  if (factory.Find(name) != nullptr) return;
  static_cast<void>(factory.Register(
      name, {.kind = NodeKind::kAction,
             .make = [&robot, of](Setup& setup) -> std::unique_ptr<Node> {
               return std::make_unique<Selector>(setup, robot, of);
             },
             .description = "Sets an entry to the selected one, or else to the default; FAILURE "
                            "where there is neither."}));
}

}  // namespace

void AddActionNodes(Factory& factory, Robot& robot) {
  constexpr NodeKind kKind = NodeKind::kAction;
  AddNode<ComputePathToPose>(factory, "ComputePathToPose", kKind, true,
                             "Has the planner compute a path.", robot);
  AddNode<ComputePathThroughPoses>(factory, "ComputePathThroughPoses", kKind, true,
                                   "Has the planner compute a path through places.", robot);
  AddMover<FollowPath>(factory, robot, "FollowPath",
                       "Has the controller follow a path, and each newer one.");
  AddMover<Spin>(factory, robot, "Spin", "Turns the robot on the spot.");
  AddMover<StraightDrive>(factory, robot, "BackUp", "Moves the robot straight backwards.", true);
  AddMover<StraightDrive>(factory, robot, "DriveOnHeading", "Moves the robot straight ahead.",
                          false);
  AddNode<Wait>(factory, "Wait", kKind, true, "RUNNING until the time is over, then SUCCESS.",
                robot);
  AddNode<ClearEntireCostmap>(factory, "ClearEntireCostmap", kKind, true,
                              "Makes planner and controller forget what the scanners have seen.",
                              robot);
  AddNode<CancelControl>(factory, "CancelControl", kKind, false,
                         "Has the controller cancel each drive, also those of other clients.",
                         robot);
  AddSelector(factory, robot, "PlannerSelector", "planner");
  AddSelector(factory, robot, "ControllerSelector", "controller");
  AddSelector(factory, robot, "SmootherSelector", "smoother");
  AddSelector(factory, robot, "GoalCheckerSelector", "goal_checker");
  AddSelector(factory, robot, "ProgressCheckerSelector", "progress_checker");
  AddSelector(factory, robot, "PathHandlerSelector", "path_handler");
}

}  // namespace musher::tree::nav2
