#include "musher/modules/skills/skills/travel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/place_text.hpp"

namespace musher::skills {
namespace {

using Kind = TravelStep::Kind;

double LengthOf(const navigation::Path& path) {
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length += navigation::Distance(path[i - 1].at, path[i].at);
  }
  return length;
}

double FlatApart(const navigation::Point& a, const navigation::Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

// The nearest place of the line between `from` and `to`; heights do not count.
navigation::Point Projected(const navigation::Point& point, const navigation::Point& from,
                            const navigation::Point& to) {
  const double x = to.x_m - from.x_m, y = to.y_m - from.y_m, square = x * x + y * y;
  const double along = (point.x_m - from.x_m) * x + (point.y_m - from.y_m) * y;
  return navigation::Between(from, to, square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0);
}

// The place of a line that is nearest to a robot.
struct NearestPlace {
  double share = 1;  // of the line; 1: its end
  navigation::Point at;
  double off_m = 0;  // of the robot
};

// On the ground heights do not count.
NearestPlace NearestOf(const Robot& robot, const navigation::Point& at,
                       const navigation::Point& from, const navigation::Point& to) {
  const double x = to.x_m - from.x_m, y = to.y_m - from.y_m;
  const double z = robot.flies() ? to.z_m - from.z_m : 0;
  const double square = x * x + y * y + z * z;
  const double along = (at.x_m - from.x_m) * x + (at.y_m - from.y_m) * y + (at.z_m - from.z_m) * z;
  NearestPlace nearest;
  if (square > 0) nearest.share = std::clamp(along / square, 0.0, 1.0);
  nearest.at = navigation::Between(from, to, nearest.share);
  nearest.off_m = robot.flies() ? navigation::Distance(at, nearest.at) : FlatApart(at, nearest.at);
  return nearest;
}

// Nullopt: no recovery helps.
std::optional<Trouble> TroubleOf(const Error& error) {
  using navigation::Fault;
  if (navigation::Is(error, Fault::kStartBlocked)) return Trouble::kTightStart;
  const bool no_path =
      navigation::Is(error, Fault::kWalledIn) || navigation::Is(error, Fault::kTimeLimit);
  return no_path ? std::optional(Trouble::kNoPath) : std::nullopt;
}

}  // namespace

bool Stands(const Robot& robot) {
  const navigation::Velocity velocity = robot.velocity();
  return navigation::Speed(velocity) < kStandingMPerS &&
         std::abs(velocity.yaw_rad_s) < kStandingRadPerS;
}

navigation::Path FromHere(const Robot& robot, const navigation::Path& path) {
  constexpr double kLookedAtM = 2;  // from the begin of the path
  constexpr double kNearM = 0.3;    // to the path: the robot is on it
  const auto pose = robot.pose();
  if (!pose || Stands(robot)) return path;
  std::size_t next = 0;  // the first point that is before the robot
  double nearest_m = kNearM, begin_m = 0;
  for (std::size_t i = 1; i < path.size() && begin_m < kLookedAtM; ++i) {
    const navigation::Point &from = path[i - 1].at, &to = path[i].at;
    const double length = navigation::Distance(from, to);
    begin_m += length;
    if (length == 0) continue;
    const double along = ((pose->at.x_m - from.x_m) * (to.x_m - from.x_m) +
                          (pose->at.y_m - from.y_m) * (to.y_m - from.y_m) +
                          (pose->at.z_m - from.z_m) * (to.z_m - from.z_m)) /
                         (length * length);
    const navigation::Point on = navigation::Between(from, to, std::clamp(along, 0.0, 1.0));
    const double off_m =
        robot.flies() ? navigation::Distance(pose->at, on) : FlatApart(pose->at, on);
    if (off_m >= nearest_m) continue;
    nearest_m = off_m;
    next = i;
  }
  if (next == 0) return path;
  navigation::Path rest{*pose};
  rest.insert(rest.end(), path.begin() + static_cast<std::ptrdiff_t>(next), path.end());
  return rest;
}

navigation::Path RestOf(const Robot& robot, const navigation::Path& path) {
  constexpr double kAsNearM = 0.3;
  constexpr double kOffPathM = 2;  // as the controller has it
  constexpr double kOnPathM = 0.01;
  const auto pose = robot.pose();
  if (!pose || path.size() < 2) return path;
  std::vector<NearestPlace> lines;
  for (std::size_t i = 1; i < path.size(); ++i) {
    lines.push_back(NearestOf(robot, pose->at, path[i - 1].at, path[i].at));
  }
  const double least_m = std::ranges::min_element(lines, {}, &NearestPlace::off_m)->off_m;
  if (least_m > kOffPathM) return path;
  std::size_t line = 0;
  while (lines[line].off_m > least_m + kAsNearM) ++line;
  // A line is passed where its end is its nearest place.
  while (line + 1 < lines.size() && lines[line].share >= 1 &&
         lines[line + 1].off_m <= lines[line].off_m) {
    ++line;
  }
  navigation::Path rest{*pose};
  if (lines[line].off_m > kOnPathM) rest.push_back({lines[line].at, path[line].yaw_rad});
  rest.insert(rest.end(), path.begin() + static_cast<std::ptrdiff_t>(line + 1), path.end());
  return rest;
}

double ApartFromLine(const Robot& robot, const navigation::Point& point,
                     const navigation::Point& from, const navigation::Point& to) {
  return NearestOf(robot, point, from, to).off_m;
}

std::string LengthText(double length_m) {
  return std::abs(length_m) < 1e6 ? fmt::format("{:.1f}", length_m)
                                  : fmt::format("{:.3g}", length_m);
}

navigation::Point WaySince(std::optional<navigation::Point>& last, const Robot& robot) {
  constexpr double kLongestStepM = 1;
  const auto now = robot.odometry();
  if (!now) return {};
  const navigation::Point from = std::exchange(last, now->at).value_or(now->at);
  if (navigation::Distance(from, now->at) > kLongestStepM) return {};
  return {now->at.x_m - from.x_m, now->at.y_m - from.y_m, now->at.z_m - from.z_m};
}

std::vector<navigation::Point> SeenAround(const Robot& robot, const navigation::Pose& pose,
                                          double most_m) {
  std::vector<navigation::Point> around;
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  for (const navigation::Point& point : robot.obstacles()) {
    const double x = point.x_m - pose.at.x_m, y = point.y_m - pose.at.y_m;
    if (std::hypot(x, y) > most_m) continue;
    around.push_back({c * x + s * y, c * y - s * x, 0});
  }
  return around;
}

Result<> CheckAltitude(const Robot& robot, const std::string& place, double height_m) {
  if (!robot.flies()) return Ok();
  const auto refuse = [&](const std::string& expected) {
    return Error{kCodeParametersInvalid,
                 fmt::format("Invalid altitude: {} is at {} m; expected {}", place,
                             navigation::MetresText(height_m), expected)};
  };
  if (height_m <= 0) return refuse("more than 0 m");
  const double ceiling_m = robot.ceiling_m().value_or(height_m);
  if (height_m <= ceiling_m) return Ok();
  return refuse(fmt::format("at most {:.2f} m, the ceiling of {}", ceiling_m, robot.name()));
}

Result<> CheckInTheAir(const Robot& robot, double height_m) {
  constexpr double kInTheAirM = 0.1;
  if (!robot.flies() || height_m >= kInTheAirM) return Ok();
  return Error{kCodeParametersInvalid,
               fmt::format("Invalid altitude: {} is at {:.2f} m; it has to take off first",
                           robot.name(), height_m)};
}

void Standstill::Note(const std::optional<navigation::Pose>& pose, Duration step) {
  if (pose && (!place_ || navigation::Distance(pose->at, *place_) > kWithinM)) {
    place_ = pose->at;
    time_ = {};
  } else {
    time_ += step;
  }
}

TravelStep Travel::Reach() const {
  const bool planner = robot_.HasPlanner();
  const bool controller = robot_.HasController();
  const bool odometry = robot_.pose().has_value();
  if (!planner && !controller && !odometry) {
    return {Kind::kPending, "ROS not available: " + robot_.name() +
                                " has no odometry, no path planner and no controller"};
  }
  if (!planner) {
    return {Kind::kPending, "Path planner server not available: no planner of " + robot_.name()};
  }
  if (!controller) {
    return {Kind::kPending, "Controller server not available: no controller of " + robot_.name()};
  }
  if (!odometry) return {Kind::kPending, robot_.WhyNoPose()};
  return {Kind::kDone};
}

TravelStep Travel::Plan(const navigation::Pose& goal, const std::optional<navigation::Pose>& start,
                        Duration step) {
  if (!plan_.valid() && robot_.HasPlanner()) {
    plan_ = robot_.ComputePath(goal, start);
    planner_missing_ = {};
  }
  if (plan_.done()) return PlanEnd(goal);
  planner_missing_ = robot_.HasPlanner() ? Duration{} : planner_missing_ + step;
  if (planner_missing_ < kLostAfter) return {Kind::kPending};
  plan_.Drop();
  planner_missing_ = {};
  return {Kind::kLost, "No response from planner"};
}

TravelStep Travel::PlanEnd(const navigation::Pose& goal) {
  const Result<navigation::Path> planned = plan_.result();
  plan_.Drop();
  if (!planned) {
    const auto& [code, why] = planned.error();
    if (code == kCodeStateInvalid) return {Kind::kLost, "Request rejected: " + why};
    if (code == kCodeNetError || !robot_.HasPlanner()) {
      return {Kind::kLost, "No response from planner: " + why};
    }
    if (Is(planned.error(), navigation::Fault::kOdometry)) {
      return {Kind::kLost, "Planning interrupted: " + why};
    }
    return {Kind::kFailed, "Planning failed: " + why, TroubleOf(planned.error())};
  }
  if (planned.value().empty()) return {Kind::kFailed, "Planning failed: the path has no points"};
  if (!std::ranges::all_of(planned.value(), [](const auto& pose) { return IsFinite(pose); })) {
    return {Kind::kFailed, "Planning failed: the path has a point that is not finite"};
  }
  const double off_m = Apart(planned.value().back().at, goal.at);
  if (off_m > kArrivedWithinM) {
    return {Kind::kFailed,
            "Planning failed: the path ends " + LengthText(off_m) + " m from the goal"};
  }
  planned_ = planned.value();
  return {Kind::kDone};
}

void Travel::Begin(const navigation::Path& path) {
  path_ = FromHere(robot_, path);
  length_m_ = LengthOf(path_);
  driven_ = {};
  drive_missing_ = {};
  // The controller replaces the drive of before without a stop; then that one is dropped.
  std::unique_ptr<skills::Drive> drive = robot_.FollowPath(path_);
  drive_ = std::move(drive);
  given_up_.reset();
}

TravelStep Travel::Drive(Duration step) {
  driven_ += step;
  const skill::Future<bool> end = drive_->end();
  if (!end.valid() || end.done()) return DriveEnd();
  drive_missing_ = robot_.pose() && robot_.HasController() ? Duration{} : drive_missing_ + step;
  if (drive_missing_ < kLostAfter) return {Kind::kPending};
  GiveUp();
  const std::string why =
      robot_.HasController() ? robot_.WhyNoPose() : "No controller of " + robot_.name();
  return {Kind::kLost, why + fmt::format(" for {:.1f} s", ToSeconds(kLostAfter))};
}

TravelStep Travel::DriveEnd() {
  const skill::Future<bool> end = drive_->end();
  drive_.reset();
  if (!end.valid()) return {Kind::kLost, "the controller has not taken the path"};
  if (!end.result()) {
    const Error& error = end.result().error();
    if (navigation::Is(error, navigation::Fault::kObstacle)) {
      return {Kind::kBlocked, error.message};
    }
    // Waited for at a stand; it comes back, or the attempts end with this reason.
    if (Is(error, navigation::Fault::kOdometry) || Is(error, navigation::Fault::kScan)) {
      return {Kind::kLost, "Drive interrupted: " + error.message};
    }
    if (error.code == kCodeStateInvalid) return {Kind::kLost, "Request rejected: " + error.message};
    if (error.code == kCodeNetError || !robot_.HasController()) {
      return {Kind::kLost, "No response from controller: " + error.message};
    }
    return {Kind::kFailed, "Navigate failed: " + error.message};
  }
  if (!end.result().value()) return {Kind::kLost, "the controller has cancelled the drive"};
  const auto pose = robot_.pose();
  if (!pose) return {Kind::kLost, robot_.WhyNoPose()};
  const double left_m = Apart(pose->at, path_.back().at);
  if (left_m > kArrivedWithinM) {
    return {Kind::kFailed,
            "Navigate failed: the drive has ended " + LengthText(left_m) + " m from the goal"};
  }
  return {Kind::kDone};
}

double Travel::Apart(const navigation::Point& a, const navigation::Point& b) const {
  if (robot_.flies()) return navigation::Distance(a, b);
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

double Travel::distance_to_goal_m() const {
  if (drive_ && drive_->distance_to_goal_m()) return *drive_->distance_to_goal_m();
  const auto pose = robot_.pose();
  return pose && !path_.empty() ? Apart(pose->at, path_.back().at) : length_m_;
}

navigation::Path Travel::RemainingPath(const navigation::Pose& pose) const {
  std::size_t next = 0;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < path_.size(); ++i) {
    const double off_m = FlatApart(pose.at, Projected(pose.at, path_[i - 1].at, path_[i].at));
    if (off_m >= nearest_m) continue;
    nearest_m = off_m;
    next = i;
  }
  navigation::Path rest{pose};
  rest.insert(rest.end(), path_.begin() + static_cast<std::ptrdiff_t>(next), path_.end());
  return rest;
}

void Travel::BeginRest() {
  const auto pose = robot_.pose();
  Begin(pose ? RemainingPath(*pose) : navigation::Path(path_));
}

std::vector<navigation::Point> Travel::InTheWay(double ahead_m) const {
  constexpr double kStepM = 0.05, kNearerM = 0.01;
  const auto pose = robot_.pose();
  if (!pose || path_.empty()) return {};
  std::vector<navigation::Point> places;
  const navigation::Path rest = RemainingPath(*pose);
  for (std::size_t i = 1; i < rest.size() && ahead_m > 0; ++i) {
    const navigation::Point &from = rest[i - 1].at, &to = rest[i].at;
    const double length_m = FlatApart(from, to), gone_m = std::min(length_m, ahead_m);
    const int steps = static_cast<int>(std::ceil(gone_m / kStepM));
    for (int step = 0; step < steps; ++step) {
      places.push_back(navigation::Between(from, to, step * kStepM / length_m));
    }
    ahead_m -= length_m;
  }
  std::vector<navigation::Point> in_the_way;
  for (const navigation::Point& point : robot_.obstacles()) {
    // As the controller has it: what is near does not hold a body that moves away from it.
    const double within_m =
        std::min(robot_.radius_m() + kObstacleMarginM, FlatApart(point, pose->at) - kNearerM);
    const bool is = std::ranges::any_of(
        places, [&](const navigation::Point& place) { return FlatApart(point, place) < within_m; });
    if (is) in_the_way.push_back(point);
  }
  return in_the_way;
}

void Travel::AddDetails(skill::Tick& tick) const {
  const double left_m = distance_to_goal_m();
  const double mean_m_s = driven_ > Duration{} ? (length_m_ - left_m) / ToSeconds(driven_) : 0;
  constexpr double kUsualMPerS = 0.5;  // until it has moved
  constexpr double kMovedMPerS = 0.05;
  tick.Detail("distance_to_goal", left_m);
  tick.Detail("current_velocity", navigation::Speed(robot_.velocity()));
  tick.Detail("estimated_time", left_m / (mean_m_s > kMovedMPerS ? mean_m_s : kUsualMPerS));
}

void Travel::GiveUp() {
  plan_.Drop();
  stopping_ = {};
  if (!drive_) return;
  drive_->Cancel();
  given_up_ = std::move(drive_);
}

bool Travel::Stop(Duration step) {
  stopping_ += step;
  if (given_up_) {
    const skill::Future<bool> end = given_up_->end();
    const bool ended = !end.valid() || end.done();
    if (!ended && robot_.HasController()) return false;
    given_up_.reset();
  }
  robot_.SetVelocity({});
  // Without odometry the time has to do.
  constexpr Duration kBraking = std::chrono::seconds(2);
  return robot_.pose() ? Stands(robot_) : stopping_ >= kBraking;
}

void Travel::End() {
  GiveUp();
  given_up_.reset();
  robot_.StopMotion();
}

}  // namespace musher::skills
