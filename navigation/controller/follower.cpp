#include "musher/navigation/controller/follower.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr double kCreep = 0.2;          // m/s; below, a change of pace counts as at this speed
constexpr double kFastestMover = 1.5;   // m/s; a higher approach is another obstacle
constexpr double kSlowestMover = 0.15;  // m/s, and 0.1 m/s more a metre away: errors of a scan
constexpr Duration kSpare = std::chrono::seconds(1);  // for a lag, after an obstacle
constexpr double kLongestStepS = 0.2;  // between updates; a longer pause is no progress

AxisControl AxisFor(const FollowerRules& rules, bool yaw) {
  return AxisControl({rules.step_s, rules.lag_s, yaw ? rules.yaw_weight : rules.place_weight,
                      yaw ? rules.yaw_rate_weight : rules.velocity_weight,
                      yaw ? rules.limits.yaw_rad_s : rules.limits.speed_m_s});
}

std::array<double, 4> Values(const Velocity& velocity) {
  return {velocity.x_m_s, velocity.y_m_s, velocity.z_m_s, velocity.yaw_rad_s};
}

// The acceleration of a trajectory in the direction of its velocity.
double AlongTrack(const TrajectoryPoint& point) {
  const Velocity &v = point.velocity, &a = point.acceleration;
  const double speed_m_s = Speed(v);
  if (speed_m_s < 1e-6) return 0;
  return (v.x_m_s * a.x_m_s + v.y_m_s * a.y_m_s + v.z_m_s * a.z_m_s) / speed_m_s;
}

// To the nearest point that is not behind a moving body.
double NearestAhead(const std::vector<Point>& points, const Pose& pose, const Velocity& velocity,
                    bool flat) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const Point& point : points) {
    const double x = point.x_m - pose.at.x_m, y = point.y_m - pose.at.y_m;
    const double z = flat ? 0 : point.z_m - pose.at.z_m;
    const double ahead = x * velocity.x_m_s + y * velocity.y_m_s + z * velocity.z_m_s;
    if (ahead >= 0) least_m = std::min(least_m, std::hypot(x, y, z));
  }
  return least_m;
}

// How fast a body may go in addition to its reference, to correct an error: so that it can brake
// before the error is corrected with a part of its acceleration. The control does not know that
// limit, and would go to and fro.
double MostCorrection(double error, double velocity_error, double acceleration) {
  constexpr double kShare = 0.4;
  return std::sqrt(2 * kShare * acceleration * std::abs(error)) + std::abs(velocity_error);
}

double FiniteOr(double value, double otherwise) {
  return std::isfinite(value) ? value : otherwise;
}

}  // namespace

Follower::Follower(const FollowerRules& rules)
    : rules_(rules),
      axes_{AxisFor(rules, false), AxisFor(rules, false), AxisFor(rules, false),
            AxisFor(rules, true)} {}

Result<> Follower::Start(Trajectory trajectory, Time now) {
  if (trajectory.points.empty()) return MakeError(Fault::kInput, "trajectory: it has no point");
  // The body may be on its way: then the new reference moves from the begin on.
  const bool moves = progress_ == Progress::kFollowing;
  // The time before an obstacle goes on where the new one leads to one, too.
  const bool drives = moves || progress_ == Progress::kWaiting;
  const Duration waited = drives ? waiting_ : Duration::zero();
  Stop();
  waiting_ = waited;
  trajectory_ = std::move(trajectory);
  progress_ = Progress::kFollowing;
  last_ = now;
  const bool goes_on = Speed(trajectory_.points[0].velocity) > 0 || !moves;
  pace_ = goes_on ? 1 : 0;
  return Ok();
}

void Follower::Stop() {
  for (AxisControl& axis : axes_) axis.Reset();
  progress_ = Progress::kIdle;
  reference_ = driven_ = waiting_ = Duration::zero();
  pace_ = pace_change_ = 0;
  highest_pace_ = 1;
  slowed_ = Duration::zero();
  slowed_until_.reset();
  halting_ = false;
  obstruction_.reset();
  failure_.reset();
}

void Follower::Fail(Error error) {
  progress_ = Progress::kFailed;
  failure_ = std::move(error);
}

// Wherever it comes to rest it is still within the distance.
bool Follower::HasArrived(const Pose& pose, const Velocity& velocity) const {
  const Pose& goal = trajectory_.points.back().pose;
  const double away_m = rules_.flat
                            ? std::hypot(goal.at.x_m - pose.at.x_m, goal.at.y_m - pose.at.y_m)
                            : Distance(goal.at, pose.at);
  const double brake_m = std::pow(Speed(velocity), 2) / (2 * rules_.limits.acceleration_m_s2);
  const double passes_m = std::isfinite(brake_m) ? brake_m : 0;
  return reference_ >= trajectory_.duration() && away_m + passes_m <= rules_.arrive_m &&
         std::abs(Wrapped(goal.yaw_rad - pose.yaw_rad)) <= rules_.arrive_rad;
}

void Follower::WatchApproach(Time now, const Pose& pose, const Velocity& velocity,
                             const std::vector<Point>& obstacles) {
  if (obstacles == seen_) return;
  const double passed_s = ToSeconds(now - seen_at_);
  const double before_m = NearestAhead(seen_, pose, velocity, rules_.flat);
  const double now_m = NearestAhead(obstacles, pose, velocity, rules_.flat);
  seen_ = obstacles;
  seen_at_ = now;
  approach_m_s_ *= 0.7;  // a set in which it is hidden, or seen elsewhere, does not end it
  if (passed_s <= 0 || passed_s > 0.5 || !std::isfinite(before_m)) return;
  const double approach_m_s = (before_m - now_m) / passed_s;
  if (approach_m_s < kSlowestMover + 0.1 * now_m) return;
  approach_m_s_ = std::max(approach_m_s_, std::min(approach_m_s, kFastestMover));
}

void Follower::NoteSlowed(Time now) {
  const MotionLimits& limits = rules_.limits;
  const double to_speed_s = limits.speed_m_s / limits.acceleration_m_s2;
  slowed_until_ = now + FromSeconds(to_speed_s) + kSpare;
}

double Follower::HighestPace(double planned_m_s) const {
  constexpr double kLeast = 0.01;
  return planned_m_s > speed_limit_m_s_ ? std::max(speed_limit_m_s_ / planned_m_s, kLeast) : 1;
}

// A moving body keeps more room, and so is slow where it passes an obstacle. Without a least speed
// it would creep there: the nearer, the longer.
double Follower::SideRoom(double speed_m_s) const {
  const ObstacleRules& rules = rules_.obstacles;
  if (speed_m_s <= rules.pass_m_s) return 0;
  return rules.side_s * std::min(speed_m_s, rules_.limits.speed_m_s);
}

void Follower::MoveReference(Time now, double dt_s, const Pose& pose, const Velocity& velocity,
                             const std::vector<Point>& obstacles) {
  const TrajectoryPoint at = trajectory_.At(reference_);
  const double planned_m_s = Speed(at.velocity);
  const double speed_m_s = std::max(pace_ * planned_m_s, FiniteOr(Speed(velocity), 0));
  // Once it waits, more has to be free: else it would start again while it still brakes.
  const double more_m = progress_ == Progress::kWaiting ? rules_.obstacles.more_ahead_m : 0;
  // The path of an obstacle until the body stands.
  const ObstacleRules& rules = rules_.obstacles;
  const double meets_m = approach_m_s_ * (rules.reaction_s + speed_m_s / rules.brake_m_s2);
  const double ahead_m =
      more_m + meets_m + std::max(BrakingDistance(speed_m_s, rules), rules.clear_ahead_m);
  obstruction_ =
      FirstObstruction(trajectory_, reference_, ahead_m, obstacles, rules_.flat, rules_.obstacles);
  const double lead_m = rules_.flat
                            ? std::hypot(at.pose.at.x_m - pose.at.x_m, at.pose.at.y_m - pose.at.y_m)
                            : Distance(at.pose.at, pose.at);
  ObstacleRules moving = rules;
  moving.margin_m += std::max(SideRoom(speed_m_s), meets_m);
  const auto passes = obstruction_ ? std::nullopt
                                   : FirstObstruction(trajectory_, reference_, ahead_m, obstacles,
                                                      rules_.flat, moving);
  if (obstruction_ || passes) NoteSlowed(now);
  highest_pace_ = HighestPace(planned_m_s);
  const bool stops = halting_ || obstruction_ || passes || lead_m > rules_.lead_m;
  const bool hold = stops || pace_ > highest_pace_;
  // The speed is the pace times that of the trajectory, so it changes with both.
  const double along_m_s2 = pace_ * pace_ * AlongTrack(at);
  const double wanted_m_s2 = hold ? -Braking(speed_m_s, passes) : rules_.limits.acceleration_m_s2;
  const double change = (wanted_m_s2 - along_m_s2) / std::max(planned_m_s, kCreep) * dt_s;
  const double before = pace_;
  const double least = stops ? 0 : std::min(highest_pace_, pace_);
  pace_ = hold ? std::clamp(pace_ + change, least, pace_)
               : std::clamp(pace_ + change, pace_, highest_pace_);
  pace_change_ = dt_s > 0 ? (pace_ - before) / dt_s : 0;
  reference_ =
      std::min(reference_ + FromSeconds(dt_s * (before + pace_) / 2), trajectory_.duration());
}

double Follower::Braking(double speed_m_s, const std::optional<Obstruction>& passed) const {
  const ObstacleRules& rules = rules_.obstacles;
  const bool comes = approach_m_s_ > 0 && passed;
  if (!obstruction_ && !comes) return rules.brake_m_s2;
  const double ahead_m = obstruction_ ? obstruction_->ahead_m : passed->ahead_m;
  const double way_m = std::max(ahead_m - (speed_m_s + approach_m_s_) * rules.reaction_s, 0.02);
  return std::clamp(speed_m_s * (speed_m_s / 2 + approach_m_s_) / way_m, rules.brake_m_s2,
                    std::max(rules.brake_m_s2, rules.hardest_m_s2));
}

Velocity Follower::Control(const Pose& pose, const Velocity& velocity) {
  // The reference over the horizon, if the pace goes on to change as it does.
  std::array<AxisReference, 4> references;
  double pace = pace_;
  Duration at = reference_;
  for (int k = 0; k < kHorizon; ++k) {
    const TrajectoryPoint point = trajectory_.At(at);
    const bool ended = at >= trajectory_.duration();
    const auto v = Values(point.velocity), a = Values(point.acceleration);
    const double change = pace > 0 && pace < 1 ? pace_change_ : 0;
    for (std::size_t axis = 0; axis < v.size(); ++axis) {
      references[axis].velocity[k] = ended ? 0 : pace * v[axis];
      references[axis].acceleration[k] = ended ? 0 : pace * pace * a[axis] + change * v[axis];
    }
    at += FromSeconds(rules_.step_s * pace);
    pace = std::clamp(pace + pace_change_ * rules_.step_s, 0.0, 1.0);
  }
  const TrajectoryPoint now = trajectory_.At(reference_);
  const auto body = Values(velocity);
  const std::array<double, 4> errors = {
      pose.at.x_m - now.pose.at.x_m, pose.at.y_m - now.pose.at.y_m, pose.at.z_m - now.pose.at.z_m,
      Wrapped(pose.yaw_rad - now.pose.yaw_rad)};
  std::array<double, 4> leads{}, corrections{}, velocity_errors{};
  for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
    if (rules_.flat && axis == 2) continue;
    const AxisReference& reference = references[axis];
    leads[axis] = reference.velocity[0] + rules_.lag_s * reference.acceleration[0];
    velocity_errors[axis] = FiniteOr(body[axis], reference.velocity[0]) - reference.velocity[0];
    corrections[axis] =
        axes_[axis].Solve(errors[axis], velocity_errors[axis], reference) - leads[axis];
  }
  const auto size = [this](const std::array<double, 4>& values) {
    return std::hypot(values[0], values[1], rules_.flat ? 0 : values[2]);
  };
  const double most =
      MostCorrection(size(errors), size(velocity_errors), rules_.limits.acceleration_m_s2);
  const double kept = std::min(1.0, most / std::max(size(corrections), 1e-9));
  const double most_yaw = MostCorrection(errors[3], velocity_errors[3], rules_.limits.yaw_rad_s2);
  Velocity command = {leads[0] + kept * corrections[0], leads[1] + kept * corrections[1],
                      leads[2] + kept * corrections[2],
                      leads[3] + std::clamp(corrections[3], -most_yaw, most_yaw)};
  const bool brakes = pace_ > highest_pace_;  // to a limit of the speed
  const double most_m_s =
      brakes ? rules_.limits.speed_m_s : std::min(rules_.limits.speed_m_s, speed_limit_m_s_);
  const double share = most_m_s / std::max(Speed(command), 1e-9);
  if (share < 1) {
    command = {command.x_m_s * share, command.y_m_s * share, command.z_m_s * share,
               command.yaw_rad_s};
  }
  return command;
}

// `moved`: the reference, in the time that has passed.
void Follower::CountTime(Time now, Duration passed, Duration moved, const Pose& pose) {
  const bool waits = progress_ == Progress::kWaiting;
  if (!waits && progress_ != Progress::kFollowing) return;
  const bool slowed = waits || (slowed_until_ && now <= *slowed_until_);
  waiting_ = waits ? waiting_ + passed : Duration::zero();
  driven_ += slowed ? moved : FromSeconds(ToSeconds(passed) * highest_pace_);
  slowed_ += slowed ? std::max(passed - moved, Duration::zero()) : Duration::zero();
  const Pose& goal = trajectory_.points.back().pose;
  if (waiting_ > rules_.give_up) {
    Fail(MakeError(Fault::kObstacle,
                   fmt::format("an obstacle at ({:.2f}, {:.2f}) has been in the way for {:.0f} s",
                               obstruction_ ? obstruction_->at.x_m : 0,
                               obstruction_ ? obstruction_->at.y_m : 0, ToSeconds(waiting_))));
  } else if (slowed_ > rules_.most_slowed + 2 * trajectory_.duration()) {
    Fail(MakeError(Fault::kObstacle, fmt::format("obstacles have cost {:.0f} s: {:.2f} m are left",
                                                 ToSeconds(slowed_), Distance(goal.at, pose.at))));
  } else if (driven_ > trajectory_.duration() + rules_.late) {
    Fail(MakeError(
        Fault::kLate,
        fmt::format("not arrived {:.1f} s after the trajectory's time "
                    "of {:.1f} s: {:.2f} m and {:.2f} rad are left",
                    ToSeconds(rules_.late), ToSeconds(trajectory_.duration()),
                    Distance(goal.at, pose.at), std::abs(Wrapped(goal.yaw_rad - pose.yaw_rad)))));
  }
}

Command Follower::Update(Time now, const Pose& pose, const Velocity& velocity,
                         const std::vector<Point>& obstacles) {
  const bool active = progress_ == Progress::kFollowing || progress_ == Progress::kWaiting;
  const double passed_s = std::max(0.0, ToSeconds(now - last_));
  const double dt_s = std::min(passed_s, kLongestStepS);
  last_ = std::max(last_, now);
  Command command;
  const Duration before = reference_;
  if (active && IsFinite(pose)) {
    WatchApproach(now, pose, velocity, obstacles);
    MoveReference(now, dt_s, pose, velocity, obstacles);
    progress_ = obstruction_ ? Progress::kWaiting : Progress::kFollowing;
    if (HasArrived(pose, velocity)) progress_ = Progress::kArrived;
  }
  CountTime(now, FromSeconds(passed_s), reference_ - before, pose);
  command.replan = progress_ == Progress::kWaiting && waiting_ >= rules_.replan_after;
  const bool drives = progress_ == Progress::kFollowing || progress_ == Progress::kWaiting;
  if (drives && IsFinite(pose)) command.velocity = Control(pose, velocity);
  command.progress = progress_;
  command.obstruction = obstruction_;
  command.failure = failure_;
  command.reference = reference_;
  return command;
}

}  // namespace musher::navigation
