// The nodes of nav2 that make paths and goals of others, and look along a path.

#include <algorithm>
#include <cmath>

#include "musher/behavior/tree/nav2/checked.hpp"
#include "musher/behavior/tree/nav2/path_places.hpp"
#include "musher/behavior/tree/nav2/register.hpp"

namespace musher::tree::nav2 {
namespace {

void Ignore(Setup& setup, std::string_view input) {
  static_cast<void>(setup.Connect({std::string(input), Direction::kIn, nullptr, false, "ignored"}));
}
void IgnoreFrames(Setup& setup) {
  for (const char* frame : {"global_frame", "robot_base_frame"}) Ignore(setup, frame);
}

class GetCurrentPose : public Action {
 public:
  GetCurrentPose(Setup& setup, const Robot& robot)
      : pose_(setup.Output<Pose>("current_pose", "where the robot is")), robot_(robot) {
    IgnoreFrames(setup);
  }

 private:
  Status Do(const Tick&) override {
    const std::optional<Pose> pose = robot_.pose();
    if (!pose) return Status::kFailure;
    pose_.Set(*pose);
    return Status::kSuccess;
  }

  OutPort<Pose> pose_;
  const Robot& robot_;
};

class GetPoseFromPath : public Action {
 public:
  explicit GetPoseFromPath(Setup& setup)
      : path_(setup.Input<Path>("path", "the path")),
        index_(setup.Input<int>("index", 0, "from 0; -1: the last one, -2: the one before it")),
        pose_(setup.Output<Pose>("pose", "the pose of the path")) {}

 private:
  Status Do(const Tick&) override {
    const std::vector<Pose>& poses = path_.Get().poses;
    const auto count = static_cast<std::int64_t>(poses.size());
    const std::int64_t index = index_.Get() < 0 ? count + index_.Get() : index_.Get();
    if (index < 0 || index >= count) return Status::kFailure;
    pose_.Set(poses[static_cast<std::size_t>(index)]);
    return Status::kSuccess;
  }

  InPort<Path> path_;
  InPort<int> index_;
  OutPort<Pose> pose_;
};

class ConcatenatePaths : public Action {
 public:
  explicit ConcatenatePaths(Setup& setup)
      : first_(setup.OptionalInput<Path>("input_path1", "the first part")),
        second_(setup.OptionalInput<Path>("input_path2", "the second part")),
        output_(setup.Output<Path>("output_path", "both")) {}

 private:
  Status Do(const Tick&) override {
    Path path = first_.Or({});
    const Path second = second_.Or({});
    path.poses.insert(path.poses.end(), second.poses.begin(), second.poses.end());
    if (path.poses.empty()) return Status::kFailure;
    output_.Set(path);
    return Status::kSuccess;
  }

  InPort<Path> first_;
  InPort<Path> second_;
  OutPort<Path> output_;
};

// Ends before the end of a path, and looks at it there.
class TruncatePath : public Action {
 public:
  explicit TruncatePath(Setup& setup)
      : distance_m_(setup.Input<double>("distance", 1.0, "m before the end of the path")),
        input_(setup.Input<Path>("input_path", "the path")),
        output_(setup.Output<Path>("output_path", "the path without its end")) {}

 private:
  Status Do(const Tick&) override {
    output_.Set(EndingBefore(input_.Get(), Checked(distance_m_)));
    return Status::kSuccess;
  }

  InPort<double> distance_m_;
  InPort<Path> input_;
  OutPort<Path> output_;
};

// A negative number: there is no limit.
double LimitOrNone(const InPort<double>& port) {
  const double limit = port.Get();
  if (std::isnan(limit)) throw PortError("port '" + port.name() + "' has to be a number");
  return limit < 0 ? PathProgress::kNoLimit : limit;
}

// What lies around the robot, or around a pose, along a path.
class TruncatePathLocal : public Action, public RunObserver {
 public:
  TruncatePathLocal(Setup& setup, const Robot& robot)
      : input_(setup.Input<Path>("input_path", "the path")),
        forward_m_(setup.Input<double>("distance_forward", 8.0, "m; negative: all")),
        backward_m_(setup.Input<double>("distance_backward", 4.0, "m; negative: all")),
        pose_(setup.OptionalInput<Pose>("pose", "instead of where the robot is")),
        m_per_rad_(setup.Input<double>("angular_distance_weight", 0.0,
                                       "m/rad, of another direction, in the search")),
        search_m_(setup.Input<double>("max_robot_pose_search_dist", PathProgress::kNoLimit,
                                      "m from where the robot was found last; negative: all")),
        output_(setup.Output<Path>("output_path", "the part of the path")),
        robot_(robot) {
    for (const char* port : {"robot_frame", "robot_base_frame", "transform_tolerance"}) {
      Ignore(setup, port);
    }
  }

 private:
  void OnNewRun(const Tick&) override { progress_ = {}; }
  Status Do(const Tick&) override {
    const double forward_m = LimitOrNone(forward_m_), backward_m = LimitOrNone(backward_m_);
    const double search_m = LimitOrNone(search_m_), m_per_rad = Checked(m_per_rad_);
    const Path& path = input_.Get();
    std::optional<Pose> pose = robot_.pose();
    if (pose_.Find() != nullptr) pose = *pose_.Find();
    if (!pose) return Status::kFailure;
    if (path.poses.empty()) {
      output_.Set(path);
    } else {
      const double at_m = progress_.Along(robot_, path, *pose, search_m, m_per_rad);
      output_.Set(Part(path, std::max(0.0, at_m - backward_m), at_m + forward_m));
    }
    return Status::kSuccess;
  }

  InPort<Path> input_;
  InPort<double> forward_m_;
  InPort<double> backward_m_;
  InPort<Pose> pose_;
  InPort<double> m_per_rad_;
  InPort<double> search_m_;
  OutPort<Path> output_;
  const Robot& robot_;
  PathProgress progress_;
};

// The goals that the robot has come near to, but not the last one.
class RemovePassedGoals : public Action {
 public:
  RemovePassedGoals(Setup& setup, const Robot& robot)
      : input_(setup.Input<Goals>("input_goals", "places to travel through")),
        radius_m_(setup.Input<double>("radius", 0.5, "m; a goal within it is passed")),
        output_(setup.Output<Goals>("output_goals", "those that are left")),
        robot_(robot) {
    IgnoreFrames(setup);
    Ignore(setup, "input_waypoint_statuses");
    static_cast<void>(
        setup.Connect({"output_waypoint_statuses", Direction::kOut, nullptr, false, "is not set"}));
  }

 private:
  Status Do(const Tick&) override {
    const double radius_m = Checked(radius_m_);
    Goals goals = input_.Get();
    const std::optional<Pose> pose = robot_.pose();
    if (!pose && !goals.poses.empty()) return Status::kFailure;
    while (goals.poses.size() > 1 && Apart(robot_, goals.poses.front(), *pose) <= radius_m) {
      goals.poses.erase(goals.poses.begin());
    }
    output_.Set(goals);
    return Status::kSuccess;
  }

  InPort<Goals> input_;
  InPort<double> radius_m_;
  OutPort<Goals> output_;
  const Robot& robot_;
};

class GetNextFewGoals : public Action {
 public:
  explicit GetNextFewGoals(Setup& setup)
      : count_(setup.Input<unsigned>("num_goals", "how many")),
        input_(setup.Input<Goals>("input_goals", "places to travel through")),
        output_(setup.Output<Goals>("output_goals", "the first ones")) {}

 private:
  Status Do(const Tick&) override {
    Goals goals = input_.Get();
    if (goals.poses.empty()) return Status::kFailure;
    goals.poses.resize(std::min<std::size_t>(goals.poses.size(), count_.Get()));
    output_.Set(goals);
    return Status::kSuccess;
  }

  InPort<unsigned> count_;
  InPort<Goals> input_;
  OutPort<Goals> output_;
};

class AppendGoalPoseToGoals : public Action {
 public:
  explicit AppendGoalPoseToGoals(Setup& setup)
      : pose_(setup.Input<Pose>("goal_pose", "the last place")),
        input_(setup.OptionalInput<Goals>("input_goals", "places to travel through")),
        output_(setup.Output<Goals>("output_goals", "these and the last one")) {}

 private:
  Status Do(const Tick&) override {
    Goals goals = input_.Or({});
    goals.poses.push_back(pose_.Get());
    output_.Set(goals);
    return Status::kSuccess;
  }

  InPort<Pose> pose_;
  InPort<Goals> input_;
  OutPort<Goals> output_;
};

// Also ValidatePath, which is an action in nav2.
class IsPathValid : public Condition {
 public:
  IsPathValid(Setup& setup, const Robot& robot)
      : path_(setup.OptionalInput<Path>("path", "the path")),
        ahead_m_(setup.Input<double>("max_lookahead_distance", -1.0,
                                     "m, how far ahead of the robot; negative: to the end")),
        robot_(robot) {
    for (const char* port :
         {"service_name", "server_timeout", "max_cost", "consider_unknown_as_obstacle",
          "layer_name", "check_full_path", "stop_at_first_collision"}) {
      Ignore(setup, port);
    }
    const Setup::Connection footprint = setup.Connect(
        {"footprint", Direction::kIn, nullptr, false, "ignored: the radius of the robot counts"});
    if (footprint.text != nullptr && !footprint.text->value.empty()) {
      setup.Report("footprint", Severity::kWarning,
                   "'footprint' has no effect: the radius of the robot counts");
    }
    static_cast<void>(
        setup.Connect({"collision_poses", Direction::kOut, nullptr, false, "is not set"}));
  }

 private:
  Status Evaluate(const Tick&) override {
    const double ahead_m = LimitOrNone(ahead_m_);
    const Path* path = path_.Find();
    const std::optional<Pose> pose = robot_.pose();
    if (path == nullptr || path->poses.empty() || !pose) return Status::kFailure;
    bool free = false;
    if (ahead_m < PathProgress::kNoLimit) {
      const double at_m = PathProgress().Along(robot_, *path, *pose, PathProgress::kNoLimit);
      free = robot_.IsFree(Part(*path, at_m, at_m + ahead_m));
    } else {
      free = robot_.IsFree(*path);
    }
    return free ? Status::kSuccess : Status::kFailure;
  }

  InPort<Path> path_;
  InPort<double> ahead_m_;
  const Robot& robot_;
};

class IsGoalNearby : public Condition, public RunObserver {
 public:
  IsGoalNearby(Setup& setup, const Robot& robot)
      : path_(setup.OptionalInput<Path>("path", "the path")),
        near_m_(setup.Input<double>("proximity_threshold", 1.0, "m of the path that are left")),
        search_m_(setup.Input<double>("max_robot_pose_search_dist", -1.0,
                                      "m from where the robot was found last; negative: all")),
        robot_(robot) {
    IgnoreFrames(setup);
  }

 private:
  void OnNewRun(const Tick&) override { progress_ = {}; }
  Status Evaluate(const Tick&) override {
    const double near_m = Checked(near_m_), search_m = LimitOrNone(search_m_);
    const Path* path = path_.Find();
    const std::optional<Pose> pose = robot_.pose();
    if (path == nullptr || path->poses.empty() || !pose) return Status::kFailure;
    const double left_m = LengthOf(*path) - progress_.Along(robot_, *path, *pose, search_m);
    return left_m < near_m ? Status::kSuccess : Status::kFailure;
  }

  InPort<Path> path_;
  InPort<double> near_m_;
  InPort<double> search_m_;
  const Robot& robot_;
  PathProgress progress_;
};

}  // namespace

void AddPathNodes(Factory& factory, Robot& robot) {
  constexpr NodeKind kAction = NodeKind::kAction;
  AddNode<GetCurrentPose>(factory, "GetCurrentPose", kAction, false,
                          "Sets an entry to where the robot is.", robot);
  AddNode<GetPoseFromPath>(factory, "GetPoseFromPath", kAction, false,
                           "Sets an entry to a pose of a path; FAILURE where it has none there.");
  AddNode<ConcatenatePaths>(factory, "ConcatenatePaths", kAction, false,
                            "Makes one path of two; FAILURE where both are empty.");
  AddNode<TruncatePath>(factory, "TruncatePath", kAction, false,
                        "Ends a path at a distance before its end; the last pose looks at that "
                        "end.");
  AddNode<TruncatePathLocal>(factory, "TruncatePathLocal", kAction, false,
                             "Takes the part of a path around the robot, or around a pose.", robot);
  AddNode<RemovePassedGoals>(factory, "RemovePassedGoals", kAction, false,
                             "Leaves the first goals out that the robot is near to; the last one "
                             "stays.",
                             robot);
  AddNode<GetNextFewGoals>(factory, "GetNextFewGoals", kAction, false,
                           "Takes the first goals; FAILURE where there are none.");
  AddNode<AppendGoalPoseToGoals>(factory, "AppendGoalPoseToGoals", kAction, false,
                                 "Adds a pose behind the goals.");
  const std::string is_free =
      "SUCCESS where the robot sees nothing on the rest of the path; FAILURE also without a scan.";
  AddNode<IsPathValid>(factory, "IsPathValid", NodeKind::kCondition, false, is_free, robot);
  AddNode<IsPathValid>(factory, "ValidatePath", kAction, false, is_free, robot);
  AddNode<IsGoalNearby>(factory, "IsGoalNearby", NodeKind::kCondition, false,
                        "SUCCESS where less than so many m of the path are left.", robot);
}

}  // namespace musher::tree::nav2
