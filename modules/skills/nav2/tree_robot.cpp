#include "musher/modules/skills/nav2/tree_robot.hpp"

#include <cmath>

#include "musher/modules/skills/skills/recovery.hpp"
#include "musher/modules/skills/skills/travel.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::skills {
namespace {

using tree::nav2::TaskEnd;

navigation::Pose FromTree(const tree::nav2::Pose& pose) {
  return {{pose.x_m, pose.y_m, pose.z_m}, pose.yaw_rad};
}
tree::nav2::Pose ToTree(const navigation::Pose& pose) {
  return {.x_m = pose.at.x_m, .y_m = pose.at.y_m, .z_m = pose.at.z_m, .yaw_rad = pose.yaw_rad};
}

constexpr const char* kNoAnswer = "no answer";
constexpr Duration kAnswerLimit = std::chrono::seconds(10);

// The code of nav2_msgs/ComputePathToPose.
std::uint16_t PlannerCode(const Error& error) {
  using navigation::Fault;
  constexpr std::uint16_t kTfError = 202, kStartOutside = 203, kGoalOutside = 204,
                          kStartOccupied = 205, kGoalOccupied = 206;
  const auto is = [&error](Fault fault) { return navigation::Is(error, fault); };
  if (is(Fault::kOdometry)) return kTfError;
  if (is(Fault::kOutside)) return kStartOutside;
  if (is(Fault::kGoalOutside)) return kGoalOutside;
  if (is(Fault::kStartBlocked)) return kStartOccupied;
  if (is(Fault::kGoalBlocked)) return kGoalOccupied;
  if (is(Fault::kTimeLimit)) return tree::nav2::kPlannerTimeout;
  if (is(Fault::kWalledIn)) return tree::nav2::kNoValidPath;
  return tree::nav2::kPlannerUnknown;
}

// The code of nav2_msgs/FollowPath.
std::uint16_t ControllerCode(const Error& error) {
  using navigation::Fault;
  constexpr std::uint16_t kTfError = 102;
  const auto is = [&error](Fault fault) { return navigation::Is(error, fault); };
  if (is(Fault::kOdometry)) return kTfError;
  if (is(Fault::kObstacle)) return tree::nav2::kPatienceExceeded;
  if (is(Fault::kLate)) return tree::nav2::kFailedToMakeProgress;
  if (is(Fault::kScan)) return tree::nav2::kNoValidControl;
  return tree::nav2::kControllerUnknown;
}

// Fails where no answer has come for 10 s.
class Deadline {
 public:
  bool IsOver(Time now) {
    if (!begin_) begin_ = now;
    return now - *begin_ >= kAnswerLimit;
  }

 private:
  std::optional<Time> begin_;
};

class PlanTask : public tree::nav2::Task {
 public:
  explicit PlanTask(skill::Future<navigation::Path> path) : path_(std::move(path)) {}

  std::optional<TaskEnd> Poll(Time now) override {
    if (!path_.valid()) {
      return TaskEnd{.error_code = tree::nav2::kPlannerUnknown, .error = "there is no planner"};
    }
    if (!path_.done()) {
      if (!deadline_.IsOver(now)) return std::nullopt;
      return TaskEnd{.error_code = tree::nav2::kPlannerTimeout, .error = kNoAnswer};
    }
    const Result<navigation::Path>& result = path_.result();
    if (!result) {
      return TaskEnd{.error_code = PlannerCode(result.error()), .error = result.error().message};
    }
    TaskEnd end{.success = true};
    for (const navigation::Pose& pose : result.value()) end.path.poses.push_back(ToTree(pose));
    return end;
  }

 private:
  skill::Future<navigation::Path> path_;
  Deadline deadline_;
};

class DriveTask : public tree::nav2::Task {
 public:
  explicit DriveTask(std::unique_ptr<Drive> drive) : drive_(std::move(drive)) {}

  std::optional<TaskEnd> Poll(Time /*now*/) override {
    const skill::Future<bool> end = drive_ == nullptr ? skill::Future<bool>() : drive_->end();
    if (!end.valid()) {
      return TaskEnd{.error_code = tree::nav2::kControllerUnknown,
                     .error = "the controller has not taken the path"};
    }
    if (!end.done()) return std::nullopt;
    if (!end.result()) {
      const Error& error = end.result().error();
      return TaskEnd{.error_code = ControllerCode(error), .error = error.message};
    }
    if (end.result().value()) return TaskEnd{.success = true};
    return TaskEnd{.error_code = tree::nav2::kControllerUnknown, .error = "it was cancelled"};
  }

 private:
  std::unique_ptr<Drive> drive_;
};

class MotionTask : public tree::nav2::Task {
 public:
  MotionTask(skills::Robot& robot, RecoveryKind kind, const Recovery::Amount& amount)
      : robot_(robot), recovery_(robot) {
    recovery_.Begin(kind, amount);
  }
  ~MotionTask() override {
    if (moves_) robot_.StopMotion();
  }

  std::optional<TaskEnd> Poll(Time now) override {
    if (robot_.flies()) return TaskEnd{.error = robot_.name() + " flies: it is for the ground"};
    const Duration step = moves_ ? now - last_ : Duration{};
    last_ = now;
    moves_ = true;
    const std::optional<Result<>> end = recovery_.Step(step);
    if (!end) return std::nullopt;
    moves_ = false;  // it stands
    if (end->ok()) return TaskEnd{.success = true};
    return TaskEnd{.error = end->error().message};
  }

 private:
  skills::Robot& robot_;
  Recovery recovery_;
  bool moves_ = false;
  Time last_{};
};

class ClearTask : public tree::nav2::Task {
 public:
  explicit ClearTask(skill::Future<bool> cleared) : cleared_(std::move(cleared)) {}

  std::optional<TaskEnd> Poll(Time now) override {
    if (!cleared_.valid()) return TaskEnd{.error = "it remembers nothing"};
    if (!cleared_.done()) {
      if (!deadline_.IsOver(now)) return std::nullopt;
      return TaskEnd{.error = kNoAnswer};
    }
    if (cleared_.result()) return TaskEnd{.success = true};
    return TaskEnd{.error = cleared_.result().error().message};
  }

 private:
  skill::Future<bool> cleared_;
  Deadline deadline_;
};

}  // namespace

std::optional<tree::nav2::Pose> TreeRobot::pose() const {
  const std::optional<navigation::Pose> pose = robot_.pose();
  if (!pose || !navigation::IsFinite(*pose)) return std::nullopt;
  return ToTree(*pose);
}

double TreeRobot::speed_m_s() const {
  const std::optional<navigation::Pose> pose = robot_.pose();
  return pose ? navigation::InBodyFrame(robot_.velocity(), pose->yaw_rad).x_m_s : 0;
}

std::unique_ptr<tree::nav2::Task> TreeRobot::ComputePath(
    const tree::nav2::Pose& goal, const std::optional<tree::nav2::Pose>& start,
    const std::string& /*planner*/) {
  std::optional<navigation::Pose> from;
  if (start) from = FromTree(*start);
  return std::make_unique<PlanTask>(robot_.HasPlanner() ? robot_.ComputePath(FromTree(goal), from)
                                                        : skill::Future<navigation::Path>());
}

std::unique_ptr<tree::nav2::Task> TreeRobot::FollowPath(const tree::nav2::Path& path,
                                                        const std::string& /*controller*/) {
  navigation::Path poses;
  for (const tree::nav2::Pose& pose : path.poses) poses.push_back(FromTree(pose));
  const bool can = robot_.HasController() && !poses.empty();
  // It was planned while the robot moved on: what lies behind the robot is left out.
  return std::make_unique<DriveTask>(can ? robot_.FollowPath(FromHere(robot_, poses)) : nullptr);
}

std::unique_ptr<tree::nav2::Task> TreeRobot::Spin(double angle_rad, Duration limit) {
  return std::make_unique<MotionTask>(robot_, RecoveryKind::kSpin,
                                      Recovery::Amount{.turn_rad = angle_rad, .longest = limit});
}

std::unique_ptr<tree::nav2::Task> TreeRobot::Drive(double distance_m, double speed_m_s,
                                                   Duration limit) {
  return std::make_unique<MotionTask>(
      robot_, RecoveryKind::kBackUp,
      Recovery::Amount{.ahead_m = distance_m, .speed_m_s = speed_m_s, .longest = limit});
}

std::unique_ptr<tree::nav2::Task> TreeRobot::ClearCostmap(const std::string& /*service*/) {
  return std::make_unique<ClearTask>(robot_.ClearMemory());
}

}  // namespace musher::skills
