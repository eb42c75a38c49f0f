#include "musher/modules/skills/skills/give_way.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace musher::skills {
namespace {

using navigation::MeetingRules;
using navigation::RobotIntent;

// Once it has given way, it looks farther: backwards it has gone away from where they meet.
constexpr MeetingRules kWhileItWaits{.look_m = 40};
constexpr Duration kFreeFor = Milliseconds(600);  // of what comes twice a second
constexpr Duration kAgainAfter = std::chrono::seconds(2);
constexpr Duration kCorneredFor = std::chrono::seconds(30);  // until the others have passed
constexpr double kNearM = 2;

}  // namespace

bool GiveWay::Needed() {
  const auto others = robot_.others();
  if (others.empty()) return false;
  const auto right = navigation::RightOfWayOf(robot_.intent(), others, {});
  if (right.first.empty()) return false;
  to_ = right.first.front()->robot;
  return true;
}

void GiveWay::Begin() {
  wanted_ = robot_.intent().path;
  free_ = {};
  refuge_.Drop();
  travel_.GiveUp();
  Enter(Phase::kBrakes);
}

void GiveWay::Enter(Phase phase) {
  phase_ = phase;
  passed_ = {};
}

std::string GiveWay::Doing() const {
  switch (phase_) {
    case Phase::kBrakes:
    case Phase::kSearches:
      return "stops";
    case Phase::kAside:
      return "drives aside";
    case Phase::kWaits:
      return "waits";
    case Phase::kCornered:
      return "finds no place for that";
  }
  return "";
}

bool GiveWay::WayIsFree() {
  RobotIntent own = robot_.intent();
  own.path = wanted_;
  const auto others = robot_.others();
  const auto right = navigation::RightOfWayOf(own, others, kWhileItWaits);
  if (!right.first.empty()) to_ = right.first.front()->robot;
  return right.first.empty();
}

// Another path than the one that it has avoided leads through where it waits.
bool GiveWay::IsInTheWay() const {
  RobotIntent own = robot_.intent();
  for (const RobotIntent& other : robot_.others()) {
    if (!navigation::GoesFirst(other, own)) continue;
    const double keep_m = own.radius_m + other.radius_m;
    navigation::Point from = other.at;
    for (const navigation::Point& to : other.path) {
      const double length_m = navigation::Distance(from, to);
      constexpr double kSampleM = 0.2, kLookedAtM = 10;
      for (double along_m = 0; along_m < std::min(length_m, kLookedAtM); along_m += kSampleM) {
        const auto at = navigation::Between(from, to, along_m / length_m);
        if (travel_.Apart(at, own.at) < keep_m) return true;
      }
      from = to;
    }
  }
  return false;
}

void GiveWay::Search() {
  if (!refuge_.valid()) refuge_ = robot_.ComputeRefuge();
  if (refuge_.valid() && !refuge_.done()) return;
  const bool found = refuge_.valid() && refuge_.result().ok() && !refuge_.result().value().empty();
  if (found) {
    travel_.Begin(refuge_.result().value());
  } else {
    robot_.NoteCornered(kCorneredFor);
  }
  refuge_.Drop();
  Enter(found ? Phase::kAside : Phase::kCornered);
}

void GiveWay::DriveAside(Duration step) {
  if (!travel_.driving()) return Enter(Phase::kSearches);  // after a pause
  const TravelStep driven = travel_.Drive(step);
  if (driven.kind == TravelStep::Kind::kPending) return;
  Enter(driven.kind == TravelStep::Kind::kDone ? Phase::kWaits : Phase::kSearches);
}

bool GiveWay::Step(Duration step) {
  passed_ += step;
  if (phase_ == Phase::kBrakes) {
    if (!travel_.Stop(step)) return false;
    robot_.StopMotion();  // the base is free for the next drive
    Enter(Phase::kSearches);
  }
  free_ = WayIsFree() ? free_ + step : Duration{};
  if (free_ >= kFreeFor) return true;
  if (phase_ == Phase::kSearches) {
    Search();
  } else if (phase_ == Phase::kAside) {
    DriveAside(step);
  } else if (passed_ >= kAgainAfter && (phase_ == Phase::kCornered || IsInTheWay())) {
    Enter(Phase::kSearches);
  }
  return false;
}

std::string GiveWay::NearRobotText(const Robot& robot) {
  const auto pose = robot.pose();
  double least_m = kNearM;
  std::string name;
  for (const RobotIntent& other : robot.others()) {
    const double away_m = pose ? navigation::Distance(pose->at, other.at) : least_m;
    if (away_m >= least_m) continue;
    least_m = away_m;
    name = other.robot;
  }
  return name.empty() ? "" : fmt::format("; {} is {:.1f} m away", name, least_m);
}

}  // namespace musher::skills
