#include "musher/modules/navigation/controller_server/path_drive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/navigation/controller_server/drive_path.hpp"
#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/place_text.hpp"

namespace musher::navigation {
namespace {

constexpr std::uint16_t kObstacleStays = 104;          // PATIENCE_EXCEEDED of nav2_msgs/FollowPath
constexpr Duration kLongestGuess = Milliseconds(100);  // of where a body has moved on
constexpr double kStandsMS = 0.05;                     // m/s; a slower body stands
constexpr double kAlignedRad = 0.35;  // between the motion and a path on which it goes on
constexpr double kMapWithinM = 0.15;  // a point so near to a wall of the map is of it
constexpr double kAsideGain = 0.7;    // rad/m: how much an aside velocity turns a differential body
constexpr double kStandsRadS = 0.05;
constexpr Duration kRests = std::chrono::seconds(1);  // beside its path
constexpr int kMostJoins = 3;                         // of a path, beside which it rests

// Of the trajectories and the reference. The command of a body with a lag leads its velocity by
// lag_s times the acceleration, which changes at once; what is left lets the command follow.
MotionLimits PlannedLimits(const ControllerRobot& robot) {
  constexpr double kShareWithLag = 0.8;
  MotionLimits limits = robot.limits;
  if (robot.lag_s > 0) {
    limits.acceleration_m_s2 *= kShareWithLag;
    limits.yaw_rad_s2 *= kShareWithLag;
  }
  return limits;
}

FollowerRules RulesOf(const ControllerRobot& robot, const ControllerConfig& config) {
  FollowerRules rules;
  rules.limits = PlannedLimits(robot);
  rules.lag_s = robot.lag_s;
  rules.flat = !robot.flies;
  rules.arrive_m = robot.arrive_m;
  rules.arrive_rad = robot.arrive_rad;
  rules.late = config.late;
  rules.replan_after = config.obstacle_time;
  rules.obstacles.radius_m = robot.radius_m;
  rules.obstacles.margin_m = robot.margin_m;
  rules.obstacles.brake_m_s2 = rules.limits.acceleration_m_s2;
  return rules;
}

GateRules GateOf(const ControllerRobot& robot) {
  GateRules rules = robot.gate;
  rules.radius_m = robot.radius_m;
  rules.scanners = robot.scanners;
  return rules;
}

GuardRules GuardOf(const ControllerRobot& robot) {
  GuardRules rules;
  rules.speed_m_s = robot.limits.speed_m_s;
  rules.yaw_rad_s = robot.limits.yaw_rad_s;
  rules.drifts = robot.flies;
  return rules;
}

std::string KeepOutText(const Point& at) {
  return fmt::format("the path leads into cells to keep out of, at ({:.2f}, {:.2f})", at.x_m,
                     at.y_m);
}

}  // namespace

PathDrive::PathDrive(const ControllerRobot& robot, const ControllerConfig& config)
    : robot_(robot),
      config_(config),
      follower_(RulesOf(robot, config)),
      seen_(config.memory),
      seen_at_(robot.scanners.size()),
      limit_(robot.limits, robot.differential),
      gate_(GateOf(robot)),
      guard_(GuardOf(robot)) {}

void PathDrive::SetMap(std::shared_ptr<const Clearance> map, Time now) {
  map_ = std::move(map);
  if (driving_) leaves_out_map_ = map_ && Fits(PathAhead(), robot_.radius_m);
  CompareWithMap(now);
}

void PathDrive::OnOdometry(const Motion& motion, Duration stamp, Time now) {
  odometry_refused_ = !poses_.Add(motion.pose, stamp);
  if (odometry_refused_) return;
  seen_.NotePlace(motion.pose.at);
  motion_ = motion;
  motion_at_ = now;
  gate_.OnVelocity(InBodyFrame(motion.velocity, motion.pose.yaw_rad), now);
  gate_.OnHeight(motion.pose.at.z_m, now);
  if (auto fault = guard_.OnPose(motion.pose, stamp, now); fault && driving_) {
    fault_ = std::move(fault);
  }
}

// Odometry comes less often than commands are sent: with the last one itself they would jump.
Pose PathDrive::PoseNow(Time now) const {
  const double passed_s = ToSeconds(std::clamp(now - motion_at_, Duration::zero(), kLongestGuess));
  Pose pose = motion_->pose;
  pose.at.x_m += motion_->velocity.x_m_s * passed_s;
  pose.at.y_m += motion_->velocity.y_m_s * passed_s;
  pose.at.z_m += motion_->velocity.z_m_s * passed_s;
  pose.yaw_rad = Wrapped(pose.yaw_rad + motion_->velocity.yaw_rad_s * passed_s);
  return pose;
}

void PathDrive::OnScan(std::size_t scanner, const Scan& scan, Duration stamp, Time now) {
  if (!gate_.OnScan(scanner, scan, stamp, now)) return;
  if (poses_.empty()) return;  // it is not known where the scan was taken
  // A planar scan does not say what is at another height, so a flyer remembers nothing; but with
  // several scanners the scan of one must not erase what another one sees.
  if (robot_.flies && robot_.scanners.size() == 1) seen_.Clear();
  const ScanMount& mount = gate_.mount(scanner);
  seen_.Add(CountedBy(mount, scan), PlacedAt(poses_.At(stamp), mount.on_body), now);
  seen_at_[scanner] = now;
  CompareWithMap(now);
}

void PathDrive::CompareWithMap(Time now) {
  obstacles_ = seen_.Points(now);
  if (leaves_out_map_ && map_) obstacles_ = NewPoints(obstacles_, *map_, kMapWithinM);
}

void PathDrive::ClearMemory() {
  seen_.Clear();
  obstacles_.clear();
}

void PathDrive::Forget() {
  motion_.reset();
  poses_.Clear();
  ClearMemory();
  std::ranges::fill(seen_at_, std::nullopt);
  gate_.Forget();
  guard_.Forget();
}

std::optional<DriveEnd> PathDrive::Blind(Time now) const {
  if (!motion_ || now - motion_at_ > config_.odometry_stale) {
    return DriveEnd{FollowCode::kTfError,
                    motion_ ? fmt::format("no odometry on {} for {:.1f} s{}", robot_.odometry,
                                          ToSeconds(now - motion_at_),
                                          odometry_refused_ ? ": its stamps do not go on" : "")
                            : fmt::format("no odometry on {} yet", robot_.odometry)};
  }
  for (std::size_t i = 0; i < seen_at_.size(); ++i) {
    const std::optional<Time>& at = seen_at_[i];
    const std::string& topic = robot_.scanners[i].topic;
    if (at && now - *at <= config_.scan_stale) continue;
    const std::string& refused = gate_.WhyRefused(i);
    const std::string why = refused.empty() ? "" : ": " + refused;
    const std::string since = at ? fmt::format("for {:.1f} s", ToSeconds(now - *at)) : "yet";
    return DriveEnd{FollowCode::kNoValidControl,
                    fmt::format("no scan on {} {}{}", topic, since, why)};
  }
  return std::nullopt;
}

// The part of the trajectory that is not driven yet.
Path PathDrive::PathAhead() const {
  constexpr int kEvery = 5;
  Path ahead = {follower_.trajectory().At(reference_).pose};
  for (Duration at = reference_; at < follower_.trajectory().duration();) {
    at += kEvery * kTrajectoryStep;
    ahead.push_back(follower_.trajectory().At(at).pose);
  }
  return ahead;
}

std::optional<Point> PathDrive::EntersKeepOut(const Path& path) const {
  if (!keep_out_) return std::nullopt;
  const auto is_in = [&](const Point& place) {
    Cell cell = keep_out_->CellOf(place);
    cell.z = 0;
    return keep_out_->Has(cell) && keep_out_->blocked[keep_out_->IndexOf(cell)] != 0;
  };
  bool was_out = false;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Point &from = path[i == 0 ? 0 : i - 1].at, &to = path[i].at;
    const int steps = static_cast<int>(Distance(from, to) / keep_out_->resolution_m * 2) + 1;
    for (int step = 1; step <= steps; ++step) {
      const Point place = Between(from, to, static_cast<double>(step) / steps);
      const bool inside = is_in(place);
      if (inside && was_out) return place;
      was_out = was_out || !inside;
    }
  }
  // All of it is inside: it does not leave.
  return was_out || path.empty() ? std::nullopt : std::optional(path.back().at);
}

void PathDrive::SetKeepOut(std::shared_ptr<const CellMap> keep_out) {
  keep_out_ = std::move(keep_out);
  if (!driving_) return;
  if (const auto at = EntersKeepOut(PathAhead())) {
    fault_ = MakeError(Fault::kInput, KeepOutText(*at));
  }
}

void PathDrive::Check(double arrive_m, double arrive_rad,
                      const std::optional<ProgressRules>& progress) {
  follower_.ArriveWithin(arrive_m, arrive_rad);
  if (!driving_ || progress != progress_.rules()) progress_.Begin(progress);
}

bool PathDrive::Fits(const Path& path, double radius_m) const {
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (!map_->FitsAlong(path[i - 1].at, path[i].at, radius_m)) return false;
  }
  return true;
}

// The speed with which the body moves along the begin of a path; 0 if it moves elsewhere.
double PathDrive::AlignedSpeed(const Path& joined) const {
  const Velocity& v = motion_->velocity;
  const double speed_m_s = Speed(v);
  if (speed_m_s < kStandsMS) return 0;
  const Point& from = joined[0].at;
  for (const Pose& pose : joined) {
    const double away_m = Distance(pose.at, from);
    if (away_m < 0.1) continue;
    const double along = (v.x_m_s * (pose.at.x_m - from.x_m) + v.y_m_s * (pose.at.y_m - from.y_m) +
                          v.z_m_s * (pose.at.z_m - from.z_m)) /
                         away_m;
    return along > speed_m_s * std::cos(kAlignedRad) ? along : 0;
  }
  return 0;
}

std::optional<DriveEnd> PathDrive::Start(const Path& path, Time now) {
  if (auto blind = Blind(now)) {
    Stop();
    return blind;
  }
  const Path joined = JoinedPath(path, PoseNow(now), robot_.join_m, !robot_.flies);
  const double aligned_m_s = joined.empty() ? 0 : AlignedSpeed(joined);
  joined_again_ = 0;
  if (driving_ && aligned_m_s == 0 && Speed(motion_->velocity) >= kStandsMS) {
    next_ = path;
    follower_.Halt();
    return std::nullopt;
  }
  return Begin(path, driving_ ? aligned_m_s : 0, now);
}

std::optional<DriveEnd> PathDrive::Begin(const Path& path, double start_speed_m_s, Time now) {
  next_.reset();
  const auto refused = [this](const std::string& why) {
    Stop();
    return DriveEnd{FollowCode::kInvalidPath, why};
  };
  Path joined = JoinedPath(path, PoseNow(now), robot_.join_m, !robot_.flies);
  if (joined.empty()) {
    return refused(fmt::format("the path begins {} m from the robot, at most {} m",
                               MetresText(Distance(path[0].at, motion_->pose.at)),
                               MetresText(robot_.join_m)));
  }
  if (const auto at = EntersKeepOut(joined)) return refused(KeepOutText(*at));
  leaves_out_map_ = map_ && Fits(joined, robot_.radius_m);
  if (robot_.differential) joined = LookingAhead(joined, start_speed_m_s > 0);
  TrajectoryRules rules;
  rules.limits = PlannedLimits(robot_);
  rules.start_speed_m_s = start_speed_m_s;
  auto trajectory = MakeTrajectory(joined, rules);
  if (!trajectory) return refused(trajectory.error().message);
  lengths_m_ = {0};
  const auto& points = trajectory.value().points;
  for (std::size_t i = 1; i < points.size(); ++i) {
    lengths_m_.push_back(lengths_m_.back() + Distance(points[i - 1].pose.at, points[i].pose.at));
  }
  CompareWithMap(now);
  if (auto started = follower_.Start(std::move(trajectory).value(), now); !started) {
    return refused(started.error().message);
  }
  if (!driving_) {
    guard_.Restart();
    limit_.Begin(now);
  }
  fault_.reset();
  rests_since_.reset();
  reference_ = {};
  driving_ = true;
  begins_ = true;
  return std::nullopt;
}

void PathDrive::Stop() {
  follower_.Stop();
  next_.reset();
  driving_ = begins_ = false;
}

DriveEnd PathDrive::Failure(const Error& error) {
  if (Is(error, Fault::kObstacle)) return {kObstacleStays, error.message};
  if (Is(error, Fault::kInput)) return {FollowCode::kInvalidPath, error.message};
  if (Is(error, Fault::kJump)) return {FollowCode::kTfError, error.message};
  return {FollowCode::kFailedToMakeProgress, error.message};
}

// What is sent of the command; an end where nothing may be.
std::optional<DriveEnd> PathDrive::Gate(const Command& command, const Pose& pose, Time now,
                                        Step& step) {
  const Velocity wanted = limit_.BeforeGate(BodyCommand(command.velocity, pose.yaw_rad),
                                            pose.yaw_rad, now, command.obstruction.has_value());
  const GateVerdict verdict = gate_.Check(wanted, now);
  step.command = limit_.AfterGate(verdict.command, pose.yaw_rad);
  step.held = Describe(verdict);
  if (verdict.kind != GateVerdict::Kind::kFree) follower_.NoteSlowed(now);
  if (auto fault = guard_.OnCommand(step.command, now)) return Failure(*fault);
  const bool stopped = verdict.kind == GateVerdict::Kind::kStopped;
  if (!stopped || verdict.held < config_.obstacle_time) return std::nullopt;
  return DriveEnd{kObstacleStays,
                  fmt::format("{}, for {:.1f} s", step.held, ToSeconds(verdict.held))};
}

Velocity PathDrive::BodyCommand(const Velocity& velocity, double yaw_rad) const {
  Velocity command = InBodyFrame(velocity, yaw_rad);
  if (!robot_.differential) return command;
  const double turn = command.x_m_s < 0 ? -kAsideGain : kAsideGain;
  const double most = robot_.limits.yaw_rad_s;
  command.yaw_rad_s = std::clamp(command.yaw_rad_s + turn * command.y_m_s, -most, most);
  command.y_m_s = 0;
  return command;
}

// A control without a velocity aside balances the turn to the path with the turn along it, and the
// body stands there.
bool PathDrive::RestsOffItsPath(bool waits, const Command& command, const Step& step, Time now) {
  const auto is_rest = [](const Velocity& velocity) {
    return Speed(velocity) < kStandsMS && std::abs(velocity.yaw_rad_s) < kStandsRadS;
  };
  const bool rests = robot_.differential && waits && !next_ &&
                     command.progress == Progress::kFollowing && step.held.empty() &&
                     is_rest(step.command) && is_rest(motion_->velocity);
  if (!rests) rests_since_.reset();
  if (rests && !rests_since_) rests_since_ = now;
  return rests && now - *rests_since_ >= kRests && joined_again_ < kMostJoins;
}

double PathDrive::DistanceLeft(Duration reference) const {
  const auto index = static_cast<std::size_t>(reference / kTrajectoryStep);
  return lengths_m_.back() - lengths_m_[std::min(index, lengths_m_.size() - 1)];
}

PathDrive::Step PathDrive::Update(Time now) {
  Step step;
  const auto end = [&](DriveEnd how) {
    Stop();
    step.command = {};
    step.end = std::move(how);
    return step;
  };
  if (!driving_) return step;
  if (auto blind = Blind(now)) return end(std::move(*blind));
  if (fault_) return end(Failure(*fault_));
  step.speed_m_s = Speed(motion_->velocity);
  const Pose pose = PoseNow(now);
  const Command command = follower_.Update(now, pose, motion_->velocity, obstacles_);
  const bool over = command.progress == Progress::kArrived || command.progress == Progress::kFailed;
  if (next_ && (over || (follower_.Halted() && step.speed_m_s < kStandsMS))) {
    if (auto refused = Begin(*std::exchange(next_, std::nullopt), 0, now)) {
      return end(std::move(*refused));
    }
    step.distance_m = lengths_m_.back();
    step.begins = std::exchange(begins_, false);
    if (auto held = Gate({}, pose, now, step)) return end(std::move(*held));
    return step;
  }
  step.begins = std::exchange(begins_, false);
  const Duration was = std::exchange(reference_, command.reference);
  step.distance_m = DistanceLeft(reference_);
  if (command.failure) return end(Failure(*command.failure));
  if (command.progress == Progress::kArrived) {
    if (limit_.IsAtRest()) return end({FollowCode::kNone, ""});
    if (auto held = Gate({}, pose, now, step)) return end(std::move(*held));
    return step;
  }
  if (command.replan && command.obstruction) {
    const Point& at = command.obstruction->at;
    return end({kObstacleStays,
                fmt::format("an obstacle at ({:.2f}, {:.2f}, {:.2f}) has been in the way for "
                            "{:.1f} s",
                            at.x_m, at.y_m, at.z_m, ToSeconds(config_.obstacle_time))});
  }
  if (!progress_.Note(pose, now)) {
    const ProgressRules& rules = *progress_.rules();
    return end({FollowCode::kFailedToMakeProgress,
                fmt::format("not moved by {:.2f} m within {:.1f} s{}", rules.radius_m,
                            ToSeconds(rules.time),
                            command.obstruction ? ": an obstacle is in the way" : "")});
  }
  if (auto held = Gate(command, pose, now, step)) return end(std::move(*held));
  if (RestsOffItsPath(was == reference_, command, step, now)) {
    ++joined_again_;
    if (auto refused = Begin(PathAhead(), 0, now)) return end(std::move(*refused));
  }
  return step;
}

}  // namespace musher::navigation
