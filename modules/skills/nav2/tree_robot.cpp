#include "musher/modules/skills/nav2/tree_robot.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/skills/nav2/mission_tasks.hpp"
#include "musher/modules/skills/skills/recovery.hpp"
#include "musher/modules/skills/skills/travel.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::skills {
namespace {

using tree::nav2::TaskEnd;

navigation::Pose FromTree(const tree::nav2::Pose& pose) {
  return {{pose.x_m, pose.y_m, pose.z_m}, pose.yaw_rad};
}
navigation::Path FromTree(const tree::nav2::Path& path) {
  navigation::Path poses;
  for (const tree::nav2::Pose& pose : path.poses) poses.push_back(FromTree(pose));
  return poses;
}
tree::nav2::Pose ToTree(const navigation::Pose& pose) {
  return {.x_m = pose.at.x_m, .y_m = pose.at.y_m, .z_m = pose.at.z_m, .yaw_rad = pose.yaw_rad};
}

constexpr const char* kNoAnswer = "no answer";
constexpr Duration kAnswerLimit = std::chrono::seconds(10);

// The code of nav2_msgs/ComputePathToPose.
std::uint16_t PlannerCode(const Error& error) {
  using navigation::Fault;
  const auto is = [&error](Fault fault) { return navigation::Is(error, fault); };
  if (is(Fault::kIdentifier)) return tree::nav2::kInvalidPlanner;
  if (is(Fault::kOdometry) || is(Fault::kFrame)) return tree::nav2::kPlannerPose;
  if (is(Fault::kOutside)) return tree::nav2::kStartOutside;
  if (is(Fault::kGoalOutside)) return tree::nav2::kGoalOutside;
  if (is(Fault::kStartBlocked)) return tree::nav2::kStartOccupied;
  if (is(Fault::kGoalBlocked)) return tree::nav2::kGoalOccupied;
  if (is(Fault::kTimeLimit) || error.code == kCodeNetError) return tree::nav2::kPlannerTimeout;
  if (is(Fault::kWalledIn)) return tree::nav2::kNoValidPath;
  return tree::nav2::kPlannerUnknown;
}

// The code of nav2_msgs/FollowPath.
std::uint16_t ControllerCode(const Error& error) {
  using navigation::Fault;
  const auto is = [&error](Fault fault) { return navigation::Is(error, fault); };
  if (is(Fault::kIdentifier)) return tree::nav2::kInvalidController;
  if (is(Fault::kOdometry) || is(Fault::kFrame)) return tree::nav2::kControllerPose;
  if (is(Fault::kInput)) return tree::nav2::kInvalidPath;
  if (is(Fault::kObstacle)) return tree::nav2::kPatienceExceeded;
  if (is(Fault::kLate)) return tree::nav2::kFailedToMakeProgress;
  if (is(Fault::kScan)) return tree::nav2::kNoValidControl;
  if (is(Fault::kTimeLimit) || error.code == kCodeNetError) return tree::nav2::kControllerTimeout;
  return tree::nav2::kControllerUnknown;
}

// The code of nav2_msgs/Spin, or of DriveOnHeading.
std::uint16_t MotionCode(bool spins, const Error& error) {
  using navigation::Fault;
  const auto is = [&error](Fault fault) { return navigation::Is(error, fault); };
  if (is(Fault::kLate)) return spins ? tree::nav2::kSpinTimeout : tree::nav2::kDriveTimeout;
  if (is(Fault::kOdometry) || is(Fault::kJump)) {
    return spins ? tree::nav2::kSpinPose : tree::nav2::kDrivePose;
  }
  if (is(Fault::kObstacle)) return spins ? tree::nav2::kSpinCollision : tree::nav2::kDriveCollision;
  return spins ? tree::nav2::kSpinUnknown : tree::nav2::kDriveUnknown;
}

// Why a path can not be followed; empty: it can.
std::string WhyNoPath(const navigation::Path& path) {
  if (path.empty()) return "the path has no points";
  const bool finite = std::ranges::all_of(path, [](const auto& pose) { return IsFinite(pose); });
  return finite ? "" : "the path has a point that is not finite";
}

// On the ground the height does not count.
double Apart(const Robot& robot, const navigation::Point& a, const navigation::Point& b) {
  if (robot.flies()) return navigation::Distance(a, b);
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

double LengthOf(const Robot& robot, const navigation::Path& path) {
  double length_m = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length_m += Apart(robot, path[i - 1].at, path[i].at);
  }
  return length_m;
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
  PlanTask(const Robot& robot, Handover& handover, const navigation::Pose& goal,
           skill::Future<navigation::Path> path)
      : robot_(robot), handover_(handover), goal_(goal), path_(std::move(path)) {}

  std::optional<TaskEnd> Poll(Time now) override {
    if (!path_.valid()) {
      return TaskEnd{.error_code = tree::nav2::kInvalidPlanner, .error = "there is no planner"};
    }
    if (!path_.done()) {
      if (!deadline_.IsOver(now)) return std::nullopt;
      return TaskEnd{.error_code = tree::nav2::kPlannerTimeout, .error = kNoAnswer};
    }
    const Result<navigation::Path>& result = path_.result();
    if (!result) {
      return TaskEnd{.error_code = PlannerCode(result.error()), .error = result.error().message};
    }
    const navigation::Path& path = result.value();
    std::string why = WhyNoPath(path);
    const double off_m = why.empty() ? Apart(robot_, path.back().at, goal_.at) : 0;
    if (off_m > kArrivedWithinM) why = "the path ends " + LengthText(off_m) + " m from the goal";
    if (!why.empty()) return TaskEnd{.error_code = tree::nav2::kNoValidPath, .error = why};
    handover_.NotePlan(goal_, path.back());
    TaskEnd end{.success = true};
    for (const navigation::Pose& pose : path) end.path.poses.push_back(ToTree(pose));
    return end;
  }

 private:
  const Robot& robot_;
  Handover& handover_;
  const navigation::Pose goal_;
  skill::Future<navigation::Path> path_;
  Deadline deadline_;
};

class DriveTask : public tree::nav2::Task {
 public:
  DriveTask(skills::Robot& robot, Handover& handover, navigation::Path path)
      : robot_(robot), handover_(handover), path_(std::move(path)) {
    if (!handover_.Rolls()) Begin();
  }
  ~DriveTask() override {
    if (drive_ != nullptr && drive_->end().valid() && !drive_->end().done()) {
      handover_.NoteEnd(path_);
      handover_.GiveUp(std::move(drive_));
    }
  }

  std::optional<TaskEnd> Poll(Time now) override {
    if (!begun_ && handover_.Rolls()) {
      const bool is_over = deadline_.IsOver(now);
      if (!handover_.HasWaited(now) && !is_over) return std::nullopt;
      handover_.EndWait();
      return TaskEnd{.error_code = tree::nav2::kControllerTimeout,
                     .error = handover_.HasMotion()
                                  ? "a motion has not ended"
                                  : "the robot does not stand after the motion before"};
    }
    if (!begun_) Begin();
    if (ended_at_once_) return ended_at_once_;
    const skill::Future<bool> end = drive_->end();
    if (!end.done()) return std::nullopt;
    const TaskEnd ended = EndOf(end.result());
    handover_.NoteEnd(path_);
    if (ended.success) handover_.NoteArrival(path_.back());
    return ended;
  }

 private:
  TaskEnd EndOf(const Result<bool>& arrived) const {
    if (!arrived) {
      const Error& error = arrived.error();
      return {.error_code = ControllerCode(error), .error = error.message};
    }
    if (!arrived.value()) {
      return {.error_code = tree::nav2::kDriveCancelled,
              .error = "the controller has cancelled the drive"};
    }
    const auto pose = robot_.pose();
    if (!pose) return {.error_code = tree::nav2::kControllerPose, .error = robot_.WhyNoPose()};
    const double left_m = Apart(robot_, pose->at, path_.back().at);
    if (left_m <= kArrivedWithinM) return {.success = true};
    return {.error_code = tree::nav2::kFailedToMakeProgress,
            .error = "the drive has ended " + LengthText(left_m) + " m from the goal"};
  }
  void Begin() {
    begun_ = true;
    handover_.EndWait();
    const std::string why = WhyNoPath(path_);
    if (!why.empty()) {
      ended_at_once_ = TaskEnd{.error_code = tree::nav2::kInvalidPath, .error = why};
    } else if (!robot_.HasController()) {
      ended_at_once_ =
          TaskEnd{.error_code = tree::nav2::kInvalidController, .error = "there is no controller"};
    } else {
      // It was planned while the robot moved on: what lies behind the robot is left out.
      const bool goes_on = handover_.GoesOn(path_);
      const navigation::Path rest = goes_on ? RestOf(robot_, path_) : FromHere(robot_, path_);
      if (goes_on && handover_.IsAtEndOf(path_, rest)) {
        ended_at_once_ = TaskEnd{.success = true};
        return;
      }
      drive_ = robot_.FollowPath(rest);
      handover_.NoteBegin(path_);
      if (drive_ != nullptr && drive_->end().valid()) return;
      ended_at_once_ = TaskEnd{.error_code = tree::nav2::kControllerTimeout,
                               .error = "the controller has not taken the path"};
    }
  }

  skills::Robot& robot_;
  Handover& handover_;
  const navigation::Path path_;
  Deadline deadline_;
  bool begun_ = false;
  std::optional<TaskEnd> ended_at_once_;
  std::unique_ptr<Drive> drive_;
};

class MotionTask : public tree::nav2::Task {
 public:
  // `amount` without `longest`: no limit.
  MotionTask(skills::Robot& robot, Handover& handover, RecoveryKind kind,
             const Recovery::Amount& amount)
      : robot_(robot), handover_(handover), kind_(kind), amount_(amount), recovery_(robot) {}
  ~MotionTask() override { GiveUp(); }

  std::optional<TaskEnd> Poll(Time now) override {
    using navigation::Fault;
    if (robot_.flies()) {
      return Failed(Error{kCodeFailed, robot_.name() + " flies: it is for the ground"});
    }
    if (!since_) since_ = now;
    const bool driven = handover_.IsDriven();
    if (driven) GiveUp();
    if (driven && begun_) return Failed(Error{kCodeFailed, "a drive has begun"});
    if (!begun_) {
      const bool has_base = !driven && handover_.Take(*this);
      if (has_base && handover_.Stands()) {
        Begin(now);
      } else if (amount_.longest && now - *since_ >= *amount_.longest) {
        return Failed(navigation::MakeError(Fault::kLate, driven     ? "a drive has not ended"
                                                          : has_base ? "the robot does not stand"
                                                                     : "a motion has not ended"));
      } else {
        if (has_base) Command();
        return std::nullopt;
      }
    }
    const Duration step = now - last_;
    last_ = now;
    commands_ = true;
    handover_.NoteMotion();
    const std::optional<Result<>> end = recovery_.Step(step);
    if (!end) return std::nullopt;
    commands_ = false;  // it has stopped
    handover_.Release(*this);
    return end->ok() ? TaskEnd{.success = true} : Failed(end->error());
  }

 private:
  // The time that it has waited is part of its limit.
  void Begin(Time now) {
    begun_ = true;
    last_ = now;
    Recovery::Amount amount = amount_;
    amount.longest = amount_.longest ? *amount_.longest - (now - *since_) : Duration::max();
    recovery_.Begin(kind_, amount);
  }
  // To stand.
  void Command() {
    commands_ = true;
    robot_.SetVelocity({});
  }
  void GiveUp() {
    if (std::exchange(commands_, false)) robot_.StopMotion();
    handover_.Release(*this);
  }
  TaskEnd Failed(const Error& error) const {
    return {.error_code = MotionCode(kind_ == RecoveryKind::kSpin, error), .error = error.message};
  }

  skills::Robot& robot_;
  Handover& handover_;
  const RecoveryKind kind_;
  const Recovery::Amount amount_;
  Recovery recovery_;
  std::optional<Time> since_;
  bool begun_ = false;
  bool commands_ = false;
  Time last_{};
};

// Nullopt: there is none.
std::optional<Duration> LimitIn(Duration limit) {
  return limit > Duration{} ? std::optional(limit) : std::nullopt;
}

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

void Handover::GiveUp(std::unique_ptr<Drive> drive) {
  drive->Cancel();
  IsDriven();  // forgets those that have ended
  given_up_.push_back(std::move(drive));
}

bool Handover::IsDriven() {
  std::erase_if(given_up_, [](const std::unique_ptr<Drive>& drive) { return drive->end().done(); });
  return !given_up_.empty() || robot_.Drives();
}

bool Handover::Take(const tree::nav2::Task& motion) {
  if (motion_ == nullptr) motion_ = &motion;
  return motion_ == &motion;
}

void Handover::Release(const tree::nav2::Task& motion) {
  if (motion_ == &motion) motion_ = nullptr;
}

bool Handover::Rolls() {
  if (HasMotion()) return true;
  if (Stands()) moved_ = false;
  return moved_;
}

bool Handover::Stands() const {
  return !robot_.pose() || skills::Stands(robot_);
}

bool Handover::HasWaited(Time now) {
  constexpr Duration kStillWaits = std::chrono::seconds(1);
  if (!waits_since_ || now - asked_at_ > kStillWaits) waits_since_ = now;
  asked_at_ = now;
  return now - *waits_since_ >= kAnswerLimit;
}

void Handover::NoteBegin(navigation::Path path) {
  last_path_ = std::move(path);
  ended_at_.reset();
  arrived_at_.reset();
}

void Handover::NoteEnd(const navigation::Path& path) {
  if (last_path_ == path) ended_at_ = robot_.pose();
}

bool Handover::GoesOn(const navigation::Path& path) const {
  constexpr double kSamePlaceM = 1;  // it may roll on a little after its end
  const auto pose = robot_.pose();
  return pose && ended_at_ && last_path_ == path &&
         Apart(robot_, pose->at, ended_at_->at) <= kSamePlaceM;
}

bool Handover::IsAtEndOf(const navigation::Path& path, const navigation::Path& rest) const {
  return arrived_at_ == path.back() && LengthOf(robot_, rest) <= kArrivedWithinM;
}

void Handover::NotePlan(const navigation::Pose& goal, const navigation::Pose& end) {
  constexpr std::size_t kMostPlans = 8;
  plans_.push_back({goal, end});
  if (plans_.size() > kMostPlans) plans_.pop_front();
}

std::optional<double> Handover::ArrivedWithin(const navigation::Pose& goal) const {
  if (!arrived_at_) return std::nullopt;
  const bool is_goal = Apart(robot_, goal.at, arrived_at_->at) < 1e-6 ||
                       std::ranges::any_of(plans_, [&](const Plan& plan) {
                         return plan.goal == goal && plan.end == *arrived_at_;
                       });
  if (!is_goal) return std::nullopt;
  return kArrivedWithinM + Apart(robot_, goal.at, arrived_at_->at);
}

std::optional<tree::nav2::Pose> TreeRobot::pose() const {
  const std::optional<navigation::Pose> pose = robot_.pose();
  if (!pose || !navigation::IsFinite(*pose)) return std::nullopt;
  return ToTree(*pose);
}

double TreeRobot::speed_m_s() const {
  const std::optional<navigation::Pose> pose = robot_.pose();
  return pose ? navigation::InBodyFrame(robot_.velocity(), pose->yaw_rad).x_m_s : 0;
}

std::optional<tree::nav2::Motion> TreeRobot::motion() const {
  if (!robot_.pose()) return std::nullopt;
  const navigation::Velocity velocity = robot_.velocity();
  return tree::nav2::Motion{navigation::Speed(velocity), velocity.yaw_rad_s};
}

std::optional<tree::nav2::Battery> TreeRobot::battery(std::string_view /*topic*/) const {
  const std::optional<BatteryLevel> level = robot_.battery();
  if (!level) return std::nullopt;
  return tree::nav2::Battery{level->share, level->voltage_v, level->charges};
}

bool TreeRobot::HasTransform(std::string_view parent, std::string_view child) const {
  return robot_.HasTransform(std::string(parent), std::string(child));
}

std::uint64_t TreeRobot::Calls(std::string_view service) const {
  const auto found = calls_.find(service);
  return found == calls_.end() ? 0 : found->second;
}

double TreeRobot::goal_tolerance_m(const tree::nav2::Pose& goal) const {
  return handover_.ArrivedWithin(FromTree(goal)).value_or(Robot::goal_tolerance_m(goal));
}

double TreeRobot::most_turn_rad_s() const {
  return Recovery::kMostRadPerS;
}

double TreeRobot::most_drive_m_s() const {
  return Recovery::kMostMPerS;
}

bool TreeRobot::IsFree(const tree::nav2::Path& path) const {
  const std::optional<navigation::Pose> pose = robot_.pose();
  if (!pose || !robot_.HasScan()) return false;
  navigation::Path rest = RestOf(robot_, FromTree(path));
  rest.insert(rest.begin(), *pose);
  return std::ranges::none_of(robot_.obstacles(), [&](const navigation::Point& obstacle) {
    // As the controller has it: what is near does not hold a body that moves away from it.
    constexpr double kNearerM = 0.01;
    const double within_m = std::min(robot_.radius_m() + kObstacleMarginM,
                                     Apart(robot_, obstacle, pose->at) - kNearerM);
    for (std::size_t i = 1; i < rest.size(); ++i) {
      if (ApartFromLine(robot_, obstacle, rest[i - 1].at, rest[i].at) < within_m) return true;
    }
    return false;
  });
}

bool TreeRobot::IsSameDrive(const tree::nav2::Path& driven, const tree::nav2::Path& next) const {
  constexpr double kAtEndM = 0.2;  // as the controller arrives
  if (driven == next) return true;
  if (driven.poses.back() != next.poses.back()) return false;
  const auto left_m = [this](const tree::nav2::Path& path) {
    return LengthOf(robot_, RestOf(robot_, FromTree(path)));
  };
  return robot_.pose() && left_m(driven) <= kAtEndM && left_m(next) <= kAtEndM;
}

bool TreeRobot::CancelDrives() {
  if (!robot_.HasController()) return false;
  robot_.CancelEarlierDrives();
  return true;
}

std::unique_ptr<tree::nav2::Task> TreeRobot::ComputePath(
    const tree::nav2::Pose& goal, const std::optional<tree::nav2::Pose>& start,
    const std::string& /*planner*/) {
  std::optional<navigation::Pose> from;
  if (start) from = FromTree(*start);
  const navigation::Pose to = FromTree(goal);
  return std::make_unique<PlanTask>(
      robot_, handover_, to,
      robot_.HasPlanner() ? robot_.ComputePath(to, from) : skill::Future<navigation::Path>());
}

std::unique_ptr<tree::nav2::Task> TreeRobot::FollowPath(const tree::nav2::Path& path,
                                                        const std::string& /*controller*/) {
  return std::make_unique<DriveTask>(robot_, handover_, FromTree(path));
}

std::unique_ptr<tree::nav2::Task> TreeRobot::Spin(double angle_rad, Duration limit) {
  return std::make_unique<MotionTask>(
      robot_, handover_, RecoveryKind::kSpin,
      Recovery::Amount{.turn_rad = angle_rad, .longest = LimitIn(limit)});
}

std::unique_ptr<tree::nav2::Task> TreeRobot::Drive(double distance_m, double speed_m_s,
                                                   Duration limit) {
  return std::make_unique<MotionTask>(
      robot_, handover_, RecoveryKind::kBackUp,
      Recovery::Amount{.ahead_m = distance_m,
                       .as_it_came = false,  // as nav2's BackUp has it
                       .speed_m_s = speed_m_s,
                       .longest = LimitIn(limit)});
}

std::unique_ptr<tree::nav2::Task> TreeRobot::ClearCostmap(const std::string& /*service*/) {
  return std::make_unique<ClearTask>(robot_.ClearMemory());
}

std::unique_ptr<tree::nav2::Task> TreeRobot::CheckPlaces(
    const tree::nav2::OccupancyRequest& request) {
  return MakePlaceCheck(robot_, request);
}

std::unique_ptr<tree::nav2::Task> TreeRobot::Navigate(const tree::nav2::Goals& places) {
  return MakeNavigation(robot_, handover_, places);
}

std::unique_ptr<tree::nav2::Task> TreeRobot::FollowObject(const std::string& topic,
                                                          Duration limit) {
  return MakeFollowing(robot_, handover_, topic, limit);
}

std::unique_ptr<tree::nav2::Task> TreeRobot::Teleoperate(Duration limit) {
  return MakeTeleoperation(robot_, handover_, limit);
}

}  // namespace musher::skills
