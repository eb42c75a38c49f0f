// The nodes of nav2 that are whole missions: to a place, behind an object, by a person; and those
// that cancel other nodes.

#include "musher/behavior/tree/nav2/checked.hpp"
#include "musher/behavior/tree/nav2/register.hpp"
#include "musher/behavior/tree/nav2/task_node.hpp"

namespace musher::tree::nav2 {
namespace {

void IgnoreTree(Setup& setup) {
  static_cast<void>(setup.OptionalInput<std::string>(
      "behavior_tree", "ignored: the robot has its own plans and recoveries"));
}

class NavigateToPose : public TaskNode {
 public:
  NavigateToPose(Setup& setup, Robot& robot)
      : TaskNode(setup, kNavigateUnknown),
        goal_(setup.Input<Pose>("goal", "where to")),
        robot_(robot) {
    IgnoreTree(setup);
  }

 private:
  std::unique_ptr<Task> Begin() override { return robot_.Navigate({.poses = {goal_.Get()}}); }

  InPort<Pose> goal_;
  Robot& robot_;
};

class NavigateThroughPoses : public TaskNode {
 public:
  NavigateThroughPoses(Setup& setup, Robot& robot)
      : TaskNode(setup, kNavigateThroughUnknown),
        goals_(setup.Input<Goals>("goals", "the places, in their order")),
        robot_(robot) {
    IgnoreTree(setup);
  }

 private:
  class Nowhere : public Task {
    std::optional<TaskEnd> Poll(Time /*now*/) override {
      return TaskEnd{.error = "there are no places"};
    }
  };

  std::unique_ptr<Task> Begin() override {
    const Goals& goals = goals_.Get();
    if (goals.poses.empty()) return std::make_unique<Nowhere>();
    return robot_.Navigate(goals);
  }

  InPort<Goals> goals_;
  Robot& robot_;
};

class FollowObject : public TaskNode {
 public:
  FollowObject(Setup& setup, Robot& robot)
      : TaskNode(setup, kFollowUnknown),
        topic_(setup.OptionalInput<std::string>("pose_topic",
                                                "where it reports its pose; else dynamic_pose")),
        limit_s_(setup.Input<double>("max_duration", 0.0, "s; then it succeeds; 0: no limit")),
        robot_(robot) {
    EndsBy(robot, Cancellable::kFollowObject);
    static_cast<void>(setup.OptionalInput<std::string>("tracked_frame", "ignored"));
    static_cast<void>(
        setup.Connect({"total_elapsed_time", Direction::kOut, nullptr, false, "is not set"}));
  }

 private:
  std::unique_ptr<Task> Begin() override {
    return robot_.FollowObject(topic_.Or("dynamic_pose"), LimitOf(limit_s_));
  }

  InPort<std::string> topic_;
  InPort<double> limit_s_;
  Robot& robot_;
};

class AssistedTeleop : public TaskNode {
 public:
  AssistedTeleop(Setup& setup, Robot& robot)
      : TaskNode(setup, kTeleopUnknown),
        limit_s_(
            setup.Input<double>("time_allowance", 10.0, "s; it fails after that; 0: no limit")),
        robot_(robot) {
    EndsBy(robot, Cancellable::kAssistedTeleop);
    static_cast<void>(setup.OptionalInput<bool>("is_recovery", "ignored"));
  }

 private:
  std::unique_ptr<Task> Begin() override { return robot_.Teleoperate(LimitOf(limit_s_)); }

  InPort<double> limit_s_;
  Robot& robot_;
};

// CancelSpin, ...
class CancelNodes : public Action {
 public:
  CancelNodes(Setup& setup, Robot& robot, Cancellable kind) : robot_(robot), kind_(kind) {
    static_cast<void>(setup.OptionalInput<std::string>("server_name", "ignored"));
    static_cast<void>(setup.OptionalInput<double>("server_timeout", "ignored: ms"));
  }

 private:
  Status Do(const Tick&) override {
    robot_.CancelNodes(kind_);
    return Status::kSuccess;
  }

  Robot& robot_;
  const Cancellable kind_;
};

void AddCancel(Factory& factory, Robot& robot, const std::string& of, Cancellable kind) {
  const std::string name = "Cancel" + of;
  if (factory.Find(name) != nullptr) return;
  static_cast<void>(factory.Register(
      name, {.kind = NodeKind::kAction,
             .make = [&robot, kind](Setup& setup) -> std::unique_ptr<Node> {
               return std::make_unique<CancelNodes>(setup, robot, kind);
             },
             .description = "Cancels each " + of +
                            " of the trees of this robot: it fails in its next tick."}));
}

}  // namespace

void AddMissionNodes(Factory& factory, Robot& robot) {
  AddMover<NavigateToPose>(factory, robot, "NavigateToPose",
                           "Has the robot travel to a place, with its own recoveries.");
  AddMover<NavigateThroughPoses>(factory, robot, "NavigateThroughPoses",
                                 "Has the robot travel to places, one after the other, with its "
                                 "own recoveries. It stands at each of them.");
  AddMover<FollowObject>(factory, robot, "FollowObject",
                         "Has the robot follow what reports its pose, at a distance.");
  AddMover<AssistedTeleop>(factory, robot, "AssistedTeleop",
                           "Leaves the base to a person, whose commands the gate checks.");
  AddCancel(factory, robot, "Spin", Cancellable::kSpin);
  AddCancel(factory, robot, "BackUp", Cancellable::kBackUp);
  AddCancel(factory, robot, "DriveOnHeading", Cancellable::kDriveOnHeading);
  AddCancel(factory, robot, "Wait", Cancellable::kWait);
  AddCancel(factory, robot, "AssistedTeleop", Cancellable::kAssistedTeleop);
  AddCancel(factory, robot, "FollowObject", Cancellable::kFollowObject);
}

}  // namespace musher::tree::nav2
