// The nodes of nav2 that ask whether places are occupied.

#include "musher/behavior/tree/nav2/checked.hpp"
#include "musher/behavior/tree/nav2/register.hpp"
#include "musher/behavior/tree/nav2/task_node.hpp"

namespace musher::tree::nav2 {
namespace {

// The parts that both have.
class PlaceNode : public TaskNode {
 protected:
  PlaceNode(Setup& setup, Robot& robot)
      : TaskNode(setup, kServiceFailed),
        whole_body_(setup.Input<bool>("use_footprint", true,
                                      "false: only what is exactly at the place counts")),
        threshold_(setup.Input<double>("cost_threshold", 254.0,
                                       "253 or less: as `use_footprint`; else ignored")),
        unknown_counts_(setup.Input<bool>("consider_unknown_as_obstacle", false,
                                          "true: what is not known counts as occupied")),
        robot_(robot) {
    static_cast<void>(setup.OptionalInput<std::string>("service_name", "ignored"));
  }

  std::unique_ptr<Task> Check(const Goals& places) {
    constexpr double kInscribed = 253;  // where the body touches something
    return robot_.CheckPlaces({.places = places,
                               .whole_body = whole_body_.Get() || Checked(threshold_) <= kInscribed,
                               .unknown_counts = unknown_counts_.Get()});
  }

 private:
  InPort<bool> whole_body_;
  InPort<double> threshold_;
  InPort<bool> unknown_counts_;
  Robot& robot_;
};

// A place of which nothing is known is taken for occupied.
class CheckPoseOccupancy : public PlaceNode {
 public:
  CheckPoseOccupancy(Setup& setup, Robot& robot)
      : PlaceNode(setup, robot), pose_(setup.Input<Pose>("pose", "the place")) {}

 private:
  std::unique_ptr<Task> Begin() override { return Check({.poses = {pose_.Get()}}); }
  Status StatusOf(const TaskEnd& end) const override {
    const bool is_free = end.success && end.occupied == std::vector<bool>{false};
    return is_free ? Status::kFailure : Status::kSuccess;
  }

  InPort<Pose> pose_;
};

class RemoveInCollisionGoals : public PlaceNode {
 public:
  RemoveInCollisionGoals(Setup& setup, Robot& robot)
      : PlaceNode(setup, robot),
        input_(setup.Input<Goals>("input_goals", "places to travel through")),
        output_(setup.Output<Goals>("output_goals", "those that are not occupied")) {
    static_cast<void>(
        setup.Connect({"input_waypoint_statuses", Direction::kIn, nullptr, false, "ignored"}));
    static_cast<void>(
        setup.Connect({"output_waypoint_statuses", Direction::kOut, nullptr, false, "is not set"}));
  }

 private:
  std::unique_ptr<Task> Begin() override {
    goals_ = input_.Get();
    return Check(goals_);
  }
  void OnEnd(const TaskEnd& end) override {
    if (!end.success || end.occupied.size() != goals_.poses.size()) return;
    Goals left;
    for (std::size_t i = 0; i < goals_.poses.size(); ++i) {
      if (!end.occupied[i]) left.poses.push_back(goals_.poses[i]);
    }
    output_.Set(left);
  }

  InPort<Goals> input_;
  OutPort<Goals> output_;
  Goals goals_;
};

}  // namespace

void AddPlaceNodes(Factory& factory, Robot& robot) {
  const std::string occupied =
      "SUCCESS where the place is occupied, also where that is not known; else FAILURE.";
  AddNode<CheckPoseOccupancy>(factory, "CheckPoseOccupancy", NodeKind::kAction, true, occupied,
                              robot);
  AddNode<CheckPoseOccupancy>(factory, "IsPoseOccupied", NodeKind::kCondition, true, occupied,
                              robot);
  AddNode<RemoveInCollisionGoals>(factory, "RemoveInCollisionGoals", NodeKind::kAction, true,
                                  "Removes the goals that are occupied; FAILURE where that is not "
                                  "known.",
                                  robot);
}

}  // namespace musher::tree::nav2
