#include "musher/modules/skills/skills/recovery.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "musher/modules/skills/skills/travel.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::skills {
namespace {

struct NamedRecovery {
  RecoveryKind kind;
  const char* name;
  Duration longest;
};
constexpr std::array<NamedRecovery, 5> kRecoveries = {{
    {RecoveryKind::kLeaveTightStart, "leave_tight_start", std::chrono::seconds(10)},
    {RecoveryKind::kClear, "clear", std::chrono::seconds(4)},
    {RecoveryKind::kWait, "wait", std::chrono::seconds(3)},
    {RecoveryKind::kBackUp, "back_up", std::chrono::seconds(8)},
    {RecoveryKind::kSpin, "spin", std::chrono::seconds(16)},
}};

constexpr double kLeaveM = 0.3;
constexpr double kRecoveryJumpM = 1;  // in one step
constexpr double kAwayM = 1;          // farther than a short one leads
constexpr double kOvershootM = 0.5;
constexpr double kLeastWayM = 0.2;    // a shorter path that it has come is none to go back on
constexpr double kRecoveryLookM = 1;  // what is farther away is not near
constexpr double kStraightRad = 0.2;
constexpr Duration kRecoveryHeldLimit = std::chrono::seconds(1);
constexpr Duration kSeenAgain = std::chrono::seconds(1);

const NamedRecovery& RecoveryOf(RecoveryKind kind) {
  return *std::find_if(kRecoveries.begin(), kRecoveries.end(),
                       [&](const NamedRecovery& named) { return named.kind == kind; });
}

// Away from what is near: what is nearest counts most.
double DirectionAway(const std::vector<navigation::Point>& around) {
  double x = 0, y = 0;
  for (const navigation::Point& point : around) {
    const double away_m = std::max(std::hypot(point.x_m, point.y_m), 0.01);
    x -= point.x_m / std::pow(away_m, 4);
    y -= point.y_m / std::pow(away_m, 4);
  }
  return std::atan2(y, x);
}

}  // namespace

Result<std::vector<RecoveryKind>> Recovery::Parse(const std::string& name,
                                                  const std::string& text) {
  std::vector<RecoveryKind> kinds;
  std::string word;
  for (const char letter : text + ",") {
    if (letter != ',' && letter != ' ') {
      word += letter;
      continue;
    }
    if (word.empty()) continue;
    const auto named = std::find_if(kRecoveries.begin(), kRecoveries.end(),
                                    [&](const NamedRecovery& one) { return one.name == word; });
    if (named == kRecoveries.end()) {
      return Error{kCodeParametersInvalid,
                   name + " has '" + word.substr(0, 40) +
                       "'; expected leave_tight_start, clear, wait, back_up and spin"};
    }
    kinds.push_back(named->kind);
    word.clear();
  }
  return kinds;
}

std::string Recovery::NameOf(RecoveryKind kind) {
  return RecoveryOf(kind).name;
}

Duration Recovery::LongestOf(RecoveryKind kind) {
  return RecoveryOf(kind).longest;
}

bool Recovery::Moves(RecoveryKind kind) {
  return kind != RecoveryKind::kClear && kind != RecoveryKind::kWait;
}

bool Recovery::Helps(RecoveryKind kind, Trouble trouble, bool flies) {
  // A person in the same door comes on once there is room.
  if (trouble == Trouble::kMover) return kind == RecoveryKind::kBackUp && !flies;
  if (trouble == Trouble::kBlocked) return !Moves(kind) || !flies;
  return !Moves(kind) || (trouble == Trouble::kTightStart && !flies);
}

void Recovery::Begin(RecoveryKind kind, const Amount& amount) {
  kind_ = kind;
  amount_ = amount;
  cleared_.Drop();
  cleared_at_.reset();
  passed_ = held_ = {};
  begin_.reset();
  way_back_.reset();
  moved_m_ = away_m_ = side_m_ = step_m_ = turned_rad_ = 0;
  turns_ = true;
}

navigation::Velocity Recovery::Command(const navigation::Pose& odometry,
                                       const std::vector<navigation::Point>& around) {
  if (kind_ == RecoveryKind::kBackUp) {
    const double speed_m_s = std::clamp(amount_.speed_m_s, 0.0, kMostMPerS);
    if (way_back_) return way_back_->Command(odometry, {speed_m_s, kMostRadPerS});
    return {.x_m_s = std::copysign(speed_m_s, amount_.ahead_m)};
  }
  if (kind_ == RecoveryKind::kSpin) {
    return {.yaw_rad_s = std::copysign(kMostRadPerS, amount_.turn_rad)};
  }
  if (!turns_) return {.x_m_s = kMostMPerS};
  const double away_rad = DirectionAway(around);
  return {.yaw_rad_s = std::clamp(2 * away_rad, -kMostRadPerS, kMostRadPerS)};
}

std::vector<navigation::Pose> Recovery::WayLeft(const navigation::Pose& odometry,
                                                double ahead_m_s) const {
  if (way_back_) return way_back_->Left(odometry);
  constexpr double kApartM = 0.1;
  const double whole_m = kind_ == RecoveryKind::kBackUp ? std::abs(amount_.ahead_m) : kLeaveM;
  const double left_m = std::max(whole_m - moved_m_, 0.0);
  const double sign = ahead_m_s < 0 ? -1 : 1;
  std::vector<navigation::Pose> way;
  const auto last = static_cast<int>(std::ceil(left_m / kApartM));
  for (int i = 0; i <= last; ++i) {
    way.push_back({{sign * std::min(i * kApartM, left_m), 0, 0}, sign < 0 ? M_PI : 0});
  }
  return way;
}

bool Recovery::IsCovered(const std::vector<navigation::Pose>& way) const {
  constexpr double kMarginM = 0.05;
  const double side_m = robot_.radius_m();
  for (const navigation::Pose& place : way) {
    const std::vector<navigation::Point> edge = {
        {side_m + kMarginM, -side_m, 0}, {side_m + kMarginM, 0, 0}, {side_m + kMarginM, side_m, 0}};
    for (const navigation::Point& at : navigation::PlacedAt(place, edge)) {
      if (!robot_.ScanCovers(at)) return false;
    }
  }
  return true;
}

double Recovery::share() const {
  const double of_time = ToSeconds(passed_) / ToSeconds(longest());
  const double back_m = way_back_ ? way_back_->length_m() : std::abs(amount_.ahead_m);
  const double of_motion = kind_ == RecoveryKind::kBackUp            ? moved_m_ / back_m
                           : kind_ == RecoveryKind::kLeaveTightStart ? moved_m_ / kLeaveM
                           : kind_ == RecoveryKind::kSpin ? turned_rad_ / std::abs(amount_.turn_rad)
                                                          : of_time;
  return std::clamp(of_motion, 0.0, 1.0);
}

void Recovery::BeginMotion(const navigation::Pose& pose, const navigation::Pose& odometry) {
  begin_ = last_ = pose;
  if (kind_ != RecoveryKind::kBackUp || !amount_.as_it_came) return;
  way_back_.emplace(odometry, robot_.travelled(), std::abs(amount_.ahead_m));
  if (way_back_->length_m() < kLeastWayM) way_back_.reset();
}

void Recovery::NoteMotion(const navigation::Pose& pose) {
  step_m_ = std::hypot(pose.at.x_m - last_.at.x_m, pose.at.y_m - last_.at.y_m);
  // With its sign: noise and swinging are no turn.
  const double side = kind_ == RecoveryKind::kSpin ? std::copysign(1, amount_.turn_rad) : 1;
  turned_rad_ += side * navigation::Wrapped(pose.yaw_rad - last_.yaw_rad);
  last_ = pose;
  const double x_m = pose.at.x_m - begin_->at.x_m, y_m = pose.at.y_m - begin_->at.y_m;
  away_m_ = std::hypot(x_m, y_m);
  const double c = std::cos(begin_->yaw_rad), s = std::sin(begin_->yaw_rad);
  const double ahead_m = c * x_m + s * y_m;
  side_m_ = std::abs(c * y_m - s * x_m);
  moved_m_ = way_back_                        ? way_back_->passed_m()
             : kind_ == RecoveryKind::kBackUp ? std::copysign(1, amount_.ahead_m) * ahead_m
                                              : away_m_;
}

bool Recovery::IsMotionOver() const {
  if (kind_ == RecoveryKind::kSpin) return turned_rad_ >= std::abs(amount_.turn_rad);
  if (way_back_) return way_back_->over();
  return moved_m_ >= (kind_ == RecoveryKind::kBackUp ? std::abs(amount_.ahead_m) : kLeaveM);
}

std::optional<Result<>> Recovery::StepOfMotion(Duration step) {
  using navigation::Fault;
  using navigation::MakeError;
  const auto pose = robot_.pose();
  if (!pose || !navigation::IsFinite(*pose)) return MakeError(Fault::kOdometry, robot_.WhyNoPose());
  if (!robot_.HasScan()) return MakeError(Fault::kScan, "it does not move without a scan");
  const auto odometry = robot_.odometry();
  if (!odometry || !navigation::IsFinite(*odometry)) {
    return MakeError(Fault::kOdometry, "No odometry of " + robot_.name());
  }
  if (!begin_) BeginMotion(*pose, *odometry);
  NoteMotion(*pose);
  if (step_m_ > kRecoveryJumpM) return MakeError(Fault::kJump, "its pose has jumped");
  if (away_m_ > std::max(kAwayM, std::abs(amount_.ahead_m) + kOvershootM)) {
    return Error{kCodeFailed, fmt::format("it has left its way: it is {:.1f} m from its begin, "
                                          "{:.1f} m to the side",
                                          away_m_, side_m_)};
  }
  const auto around = SeenAround(robot_, *pose, kRecoveryLookM);
  if (kind_ == RecoveryKind::kLeaveTightStart) {
    if (around.empty() && moved_m_ == 0) {
      return Error{kCodeFailed, "its scan sees nothing near that it could leave"};
    }
    if (around.empty() || std::abs(DirectionAway(around)) < kStraightRad) turns_ = false;
  }
  if (IsMotionOver()) return Result<>();
  const navigation::Velocity command = Command(*odometry, around);
  if (way_back_ && way_back_->lost()) {
    return Error{kCodeFailed, "it has left the path that it has come"};
  }
  if (command.x_m_s != 0 && !IsCovered(WayLeft(*odometry, command.x_m_s))) {
    const bool back = command.x_m_s < 0;
    return MakeError(Fault::kScan,
                     fmt::format("it does not go {}: no scan covers what is {} it",
                                 back ? "backwards" : "ahead", back ? "behind" : "ahead of"));
  }
  robot_.SetVelocity(command);
  const std::string held_by = robot_.HeldBy();
  held_ = held_by.empty() ? Duration{} : held_ + step;
  if (held_ >= kRecoveryHeldLimit) return MakeError(Fault::kObstacle, held_by);
  if (passed_ < longest()) return std::nullopt;
  return MakeError(Fault::kLate, fmt::format("it has moved by {:.2f} m and {:.2f} rad only",
                                             moved_m_, turned_rad_));
}

std::optional<Result<>> Recovery::Step(Duration step) {
  passed_ += step;
  std::optional<Result<>> end;
  if (kind_ == RecoveryKind::kWait) {
    if (passed_ >= longest()) end = Result<>();
  } else if (kind_ == RecoveryKind::kClear) {
    end = StepOfClear();
  } else {
    end = StepOfMotion(step);
    if (end) robot_.StopMotion();  // the base is free for the next drive
  }
  return end;
}

std::optional<Result<>> Recovery::StepOfClear() {
  if (!cleared_.valid()) cleared_ = robot_.ClearMemory();
  if (!cleared_.valid()) return Error{kCodeFailed, "it remembers nothing"};
  if (!cleared_.done()) {
    if (passed_ < RecoveryOf(kind_).longest) return std::nullopt;
    return Error{kCodeFailed, "planner and controller have not answered"};
  }
  if (!cleared_.result()) return cleared_.result().error();
  if (!cleared_at_) cleared_at_ = passed_;
  if (passed_ - *cleared_at_ < kSeenAgain) return std::nullopt;
  return Result<>();
}

}  // namespace musher::skills
