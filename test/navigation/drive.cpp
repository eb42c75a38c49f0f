#include "musher/test/navigation/drive.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace musher::navigation::testing {
namespace {

constexpr double kStepS = 1.0 / 60;
constexpr double kStandsMS = 0.05;  // m/s; a slower body does not drive towards a mover
constexpr int kStepsAScan = 6;
constexpr double kScanM = 4;
constexpr int kRays = 120;

// Where a ray meets a disc, if nearer than `range_m`.
double ToDisc(const Point& from, double angle, const Point& centre, double radius_m,
              double range_m) {
  const double x = centre.x_m - from.x_m, y = centre.y_m - from.y_m;
  const double along = x * std::cos(angle) + y * std::sin(angle);
  const double square = radius_m * radius_m - (x * x + y * y - along * along);
  if (along < 0 || square < 0) return range_m;
  return std::min(range_m, std::max(0.0, along - std::sqrt(square)));
}

class Run {
 public:
  Run(const CellMap& map, const Pose& start, const Pose& goal, const DriveOptions& options)
      : options_(options),
        walls_(map),
        pose_(start),
        goal_(goal),
        movers_(options.movers),
        follower_(options.follower) {}

  DriveResult Do() {
    if (!Plan(walls_.map())) {
      result_.end = DriveResult::End::kRefused;
      return result_;
    }
    result_.least_room_m = 1;
    double squares = 0;
    int steps = 0;
    for (; Seconds(steps) < options_.longest_s; ++steps) {
      if (steps % kStepsAScan == 0) Look();
      const Command command = follower_.Update(Now(steps), pose_, velocity_, seen_);
      result_.waited_s += command.progress == Progress::kWaiting ? kStepS : 0;
      if (command.progress == Progress::kArrived) result_.end = DriveResult::End::kArrived;
      if (command.failure) result_.reason = command.failure->message;
      if (command.progress != Progress::kFollowing && command.progress != Progress::kWaiting) break;
      const double error_m = Distance(trajectory_.At(command.reference).pose.at, pose_.at);
      squares += error_m * error_m;
      result_.tracking_most_m = std::max(result_.tracking_most_m, error_m);
      if (command.replan && steps >= next_plan_) Replan(steps);
      Move(command.velocity);
      if (options_.disturb) options_.disturb(Seconds(steps), pose_);
      MoveMovers();
      Compare();
    }
    result_.tracking_rms_m = std::sqrt(squares / std::max(steps, 1));
    result_.seconds = Seconds(steps);
    result_.pose = pose_;
    return result_;
  }

 private:
  static double Seconds(int steps) { return steps * kStepS; }
  static Time Now(int steps) {
    return Time{} + std::chrono::nanoseconds(std::int64_t{steps} * 1'000'000'000 / 60);
  }

  bool Plan(const CellMap& map, int steps = 0) {
    const auto planner = Planner::Make(map, options_.planner);
    if (!planner.ok()) return Refuse(planner.error());
    const auto plan = planner.value().Find(pose_, goal_);
    if (!plan.ok()) return Refuse(plan.error());
    auto trajectory = MakeTrajectory(plan.value().path, options_.trajectory);
    if (!trajectory.ok()) return Refuse(trajectory.error());
    trajectory_ = trajectory.value();
    return follower_.Start(std::move(trajectory).value(), Now(steps)).ok();
  }

  bool Refuse(const Error& error) {
    result_.reason = error.message;
    return false;
  }

  void Replan(int steps) {
    next_plan_ = steps + 120;
    CellMap map = walls_.map();
    BlockPoints(seen_, map);
    if (Plan(map, steps)) ++result_.replans;
  }

  void Look() {
    Scan scan{0, 2 * M_PI / kRays, 0.05, kScanM - 0.01, {}};
    for (int i = 0; i < kRays; ++i) {
      const double angle = pose_.yaw_rad + i * scan.step_rad;
      double range_m = kScanM;
      for (const Mover& mover : movers_) {
        range_m = ToDisc(pose_.at, angle, mover.At(), mover.radius_m, range_m);
      }
      scan.ranges_m.push_back(static_cast<float>(ToWall(angle, range_m)));
    }
    seen_ = NewPoints(PointsOf(scan, pose_), walls_, 0.1);
  }

  double ToWall(double angle, double range_m) const {
    const double step_m = walls_.map().resolution_m / 2;
    for (double at_m = 0; at_m < range_m;) {
      const Point place = {pose_.at.x_m + at_m * std::cos(angle),
                           pose_.at.y_m + at_m * std::sin(angle), 0};
      const Cell cell = walls_.map().CellOf(place);
      if (!walls_.map().Has(cell)) return range_m;
      const double away_m = walls_.OfCell(walls_.map().IndexOf(cell));
      if (away_m == 0) return at_m;
      at_m += std::max(step_m, away_m - 2 * walls_.map().resolution_m);
    }
    return range_m;
  }

  void Move(const Velocity& command) {
    const double share = options_.lag_s > 0 ? 1 - std::exp(-kStepS / options_.lag_s) : 1;
    velocity_.x_m_s += share * (command.x_m_s - velocity_.x_m_s);
    velocity_.y_m_s += share * (command.y_m_s - velocity_.y_m_s);
    velocity_.yaw_rad_s += share * (command.yaw_rad_s - velocity_.yaw_rad_s);
    pose_.at.x_m += velocity_.x_m_s * kStepS;
    pose_.at.y_m += velocity_.y_m_s * kStepS;
    pose_.yaw_rad += velocity_.yaw_rad_s * kStepS;
    result_.highest_m_s = std::max(result_.highest_m_s, Speed(velocity_));
  }

  void MoveMovers() {
    for (Mover& mover : movers_) {
      const double length_m = Distance(mover.from, mover.to);
      Mover next = mover;
      next.at_m += (mover.back ? -1 : 1) * mover.speed_m_s * kStepS;
      const double now_m = Distance(mover.At(), pose_.at), next_m = Distance(next.At(), pose_.at);
      const double keep_m = mover.radius_m + options_.body_radius_m + 0.3;
      if (mover.yields && next_m < keep_m && next_m < now_m) {
        mover.stood_s += kStepS;
        if (mover.stood_s > 5) mover.back = !mover.back;
        continue;
      }
      mover.stood_s = 0;
      mover.at_m = std::clamp(next.at_m, 0.0, length_m);
      if (mover.at_m != next.at_m) mover.back = !mover.back;
    }
  }

  void Compare() {
    result_.least_room_m =
        std::min(result_.least_room_m,
                 walls_.At(pose_.at, 1 + options_.body_radius_m) - options_.body_radius_m);
    const Mover* touched = nullptr;
    for (const Mover& mover : movers_) {
      const bool touches = Distance(mover.At(), pose_.at) < mover.radius_m + options_.body_radius_m;
      if (touches) touched = &mover;
    }
    if (touched && !touched_) {
      const Point to = touched->At();
      const double towards =
          (to.x_m - pose_.at.x_m) * velocity_.x_m_s + (to.y_m - pose_.at.y_m) * velocity_.y_m_s;
      const double towards_m_s = towards / std::max(Distance(to, pose_.at), 1e-6);
      (towards_m_s > kStandsMS ? result_.hits_of_body : result_.hits_of_movers) += 1;
    }
    touched_ = touched != nullptr;
  }

  const DriveOptions& options_;
  Clearance walls_;
  Pose pose_;
  Pose goal_;
  Velocity velocity_;
  std::vector<Mover> movers_;
  Follower follower_;
  Trajectory trajectory_;
  std::vector<Point> seen_;
  int next_plan_ = 0;
  bool touched_ = false;
  DriveResult result_;
};

}  // namespace

Point Mover::At() const {
  const double length_m = Distance(from, to);
  return length_m > 0 ? Between(from, to, at_m / length_m) : from;
}

DriveOptions::DriveOptions() {
  planner.radius_m = 0.35;
  follower.lag_s = lag_s;
  follower.obstacles.radius_m = body_radius_m;
}

DriveResult Drive(const CellMap& map, const Pose& start, const Pose& goal,
                  const DriveOptions& options) {
  return Run(map, start, goal, options).Do();
}

}  // namespace musher::navigation::testing
