#include "musher/modules/skills/robot/flight_hold.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "musher/modules/skills/robot/landing_places.hpp"

namespace musher::skills {
namespace {

constexpr double kBrakedMS = 0.15;
constexpr Duration kLongestBraking = std::chrono::seconds(1);  // a wind does not brake
constexpr double kSlowBelowM = 0.6;
constexpr double kStillM = 0.02;
constexpr Duration kStands = std::chrono::seconds(2);
// A height that stands is the ground's below it; above, it may be an estimate that has stopped, or
// an updraught.
constexpr double kGroundToleranceM = 0.3;
constexpr double kSurelyInTheAirM = 0.3;
// Off its place by so much it is commanded back with all its speed: a wind that it can hold against
// never keeps it there.
constexpr double kOffPlaceM = 0.3;
constexpr double kUnmovedM = 0.05;
constexpr Duration kUnmoved = std::chrono::seconds(1);
// Of a flyer that another program commands, and after that.
constexpr double kFlownM = 0.2;
constexpr double kDriftsM = 0.1;
constexpr double kLiftedM = 0.05;
// Neither a flyer nor a hand moves it farther.
constexpr double kJumpM = 0.5;
constexpr double kFastestMS = 3;
constexpr double kStoodM = 0.3;
constexpr Duration kStoodFor = Milliseconds(500);
constexpr Duration kTakenFor = std::chrono::seconds(10);  // a person may go on
constexpr Duration kTakenThere = std::chrono::seconds(2);
constexpr Duration kLongestAside = std::chrono::seconds(8);
constexpr double kThereM = 0.2;
constexpr Duration kOdometryStands = std::chrono::minutes(1);  // until it tries again

}  // namespace

void FlightHold::Use() {
  armed_ = true;
  landed_ = arms_ = false;
  braking_ = still_ = unmoved_ = held_ = {};
  place_.reset();
  taken_.reset();
  aside_.reset();
  descent_held_ = false;
  other_.reset();
  restored_.reset();
  ended_.clear();
  hold_.Reset();
}

void FlightHold::Land() {
  armed_ = arms_ = false;
  landed_ = true;
  other_.reset();
  restored_.reset();
  ended_.clear();
}

void FlightHold::NoteOther(const navigation::Velocity& command) {
  if (armed_ && low_) return;  // it lands, whatever commands it
  if (!other_) other_.emplace();
  other_->silent = {};
  other_->left_at.reset();
  other_->stood = {};
  other_->command = command;
  other_->flies = other_->flies || armed_;
  if (armed_) End("another program commands it");
}

void FlightHold::WatchOther(const navigation::Pose* pose, Duration step) {
  OtherProgram& other = *other_;
  other.silent += step;
  if (pose != nullptr) NoteFollowed(*pose);
  if (other.flies) landed_ = false;
  if (other.flies && low_) return Use();
  if (other.silent < kOtherEnds) return;
  if (!other.flies) return other_.reset();
  if (pose != nullptr && pose->at.z_m < kInTheAirM) return Land();
  AfterOther(pose, step);
}

// One that is only carried while another program sends does not follow its commands.
void FlightHold::NoteFollowed(const navigation::Pose& pose) {
  OtherProgram& other = *other_;
  const navigation::Point was = std::exchange(other.was_at, pose.at).value_or(pose.at);
  if (other.silent >= kOtherEnds) return;
  const navigation::Velocity towards = navigation::InBodyFrame(other.command, -pose.yaw_rad);
  const double speed_m_s = navigation::Speed(towards);
  if (!(speed_m_s > 0) || !std::isfinite(speed_m_s)) return;  // it only turns
  other.followed_m +=
      ((pose.at.x_m - was.x_m) * towards.x_m_s + (pose.at.y_m - was.y_m) * towards.y_m_s +
       (pose.at.z_m - was.z_m) * towards.z_m_s) /
      speed_m_s;
  if (other.followed_m >= kFlownM && pose.at.z_m >= kInTheAirM) other.flies = true;
}

void FlightHold::AfterOther(const navigation::Pose* pose, Duration step) {
  OtherProgram& other = *other_;
  if (other.command.z_m_s >= 0) return Use();
  if (pose == nullptr) return;  // it may have landed
  if (!other.left_at) other.left_at = pose->at;
  if (pose->at.z_m > other.left_at->z_m + kLiftedM) return Land();
  const double aside_m =
      std::hypot(pose->at.x_m - other.left_at->x_m, pose->at.y_m - other.left_at->y_m);
  if (aside_m > kDriftsM) return Use();  // one that sinks may be landed by its firmware
  other.stood += step;
  if (other.stood >= kMayStand) Land();
}

void FlightHold::End(std::string why) {
  armed_ = arms_ = false;
  ended_ = std::move(why);
}

void FlightHold::SetBatteryLow(bool low) {
  if (low == low_) return;  // a repeated report does not begin the descent again
  low_ = low;
  held_ = {};
  taken_.reset();
  aside_.reset();
  arms_ = low && !landed_ && !armed_;
  still_ = {};
  lowest_m_ = std::numeric_limits<double>::infinity();
}

void FlightHold::NoteCharging() {
  if (StandsHigh()) Land();
}

void FlightHold::NoteStopped() {
  stopped_ = true;
  still_ = unmoved_ = {};
}

bool FlightHold::StandsHigh() const {
  return armed_ && low_ && still_ >= kStands;
}

std::optional<navigation::Velocity> FlightHold::Command(const std::optional<navigation::Pose>& pose,
                                                        double speed_m_s, Duration step) {
  const bool known = pose && navigation::IsFinite(*pose);
  if (known && arms_) {  // where it is found decides: one that is lifted later is in a hand
    arms_ = false;
    if (pose->at.z_m >= kSurelyInTheAirM) Use();
  }
  if (known && restored_) {
    const navigation::Point was = *std::exchange(restored_, std::nullopt);
    const bool flies =
        pose->at.z_m >= kInTheAirM && navigation::Distance(pose->at, was) < kMovedOnM;
    if (flies && !armed_) Use();
  }
  if (other_) WatchOther(known ? &*pose : nullptr, step);
  if (known) {
    FollowJump(*pose, step);
  } else {
    last_.reset();  // it may have been carried meanwhile
  }
  if (!armed_) return std::nullopt;
  if (!known) {
    hold_.Reset();
    unmoved_ = {};
    return navigation::Velocity{0, 0, low_ ? -kLastDescentMps : 0, 0};
  }
  if (pose->at.z_m < kInTheAirM && !(place_ && low_)) {  // a descent ends where it has stood
    Land();
    return std::nullopt;
  }
  braking_ += step;
  if (!place_ && speed_m_s > kBrakedMS && braking_ < kLongestBraking) return navigation::Velocity{};
  if (!place_) {
    place_ = pose;
    unmoved_at_ = pose->at;
    lowest_m_ = pose->at.z_m;
  }
  if (low_) return Descend(*pose, step);
  if (std::string why = MovedAgainstCommands(*pose, step); !why.empty()) {
    End(std::move(why));
    return std::nullopt;
  }
  return hold_.Command(*place_, *pose, PositionHold::SecondsOf(step));
}

// Odometry that stood, and goes on, has not jumped: the flyer has moved meanwhile. But where the
// place was taken from it while it stood, the flyer had gone on from there.
void FlightHold::FollowJump(const navigation::Pose& pose, Duration step) {
  same_ += step;
  if (last_ == pose) return;
  const Duration moved_for = std::exchange(same_, Duration{});
  const std::optional<navigation::Pose> from = std::exchange(last_, pose);
  if (!from || !place_) return;
  const bool stood = *from == *place_ && moved_for >= kStoodFor;
  const double most_m = stood ? kStoodM : kJumpM + kFastestMS * ToSeconds(moved_for);
  if (navigation::Distance(from->at, pose.at) <= most_m) return;
  place_ = pose;
  unmoved_at_ = pose.at;
  unmoved_ = still_ = held_ = {};
  taken_.reset();
  aside_.reset();
  lowest_m_ = pose.at.z_m;
  hold_.Reset();  // the map may have turned below it, and with that the wind
}

std::string FlightHold::MovedAgainstCommands(const navigation::Pose& pose, Duration step) {
  const double off_m = navigation::Distance(pose.at, place_->at);
  const double sunk_m = place_->at.z_m - pose.at.z_m;
  if (sunk_m > kSunkM) {
    return fmt::format("it came {:.2f} m lower than its place against its commands", sunk_m);
  }
  if (off_m > kLostM) {
    return fmt::format("it was carried {:.1f} m off its place against its commands", off_m);
  }
  if (off_m < kOffPlaceM || navigation::Distance(pose.at, unmoved_at_) > kUnmovedM) {
    unmoved_at_ = pose.at;
    unmoved_ = {};
    return "";
  }
  unmoved_ += step;
  if (unmoved_ < kUnmoved) return "";
  return fmt::format("it stands {:.2f} m off its place against its commands", off_m);
}

// Around the one that is taken; nullopt: its scan covers the way to none that is left.
std::optional<navigation::Point> FlightHold::NextPlace() {
  while (auto place = LandingPlace(*taken_, tried_++, kMostAsideM)) {
    if (Sees(*place)) return place;
  }
  return std::nullopt;
}

std::optional<navigation::Velocity> FlightHold::GoAside(const navigation::Pose& pose,
                                                        Duration step) {
  const bool held = std::exchange(descent_held_, false);
  const bool stopped = std::exchange(stopped_, false);
  if (!aside_) {
    held_ = held ? held_ + step : std::min(held_, Duration{});
    if (held_ < (taken_ ? kTakenThere : kTakenFor)) return std::nullopt;
    held_ = {};
    if (!taken_) {
      taken_ = pose.at;
      tried_ = 0;
    }
    aside_ = NextPlace();
    aside_from_ = pose.at;
    unmoved_ = going_ = {};
    if (!aside_) {  // the same places again, later
      tried_ = 0;
      held_ = kTakenThere - kTakenFor;
      return std::nullopt;
    }
  }
  going_ += step;
  still_ = {};
  const bool stands = navigation::Distance(pose.at, aside_from_) < kUnmovedM;
  unmoved_ = stands && !stopped ? unmoved_ + step : Duration{};
  if (unmoved_ >= kUnmoved) {  // its odometry stands: each place would look taken
    aside_.reset();
    place_ = pose;
    hold_.Reset();
    held_ = -kOdometryStands;
    return std::nullopt;
  }
  place_->at.x_m = aside_->x_m;
  place_->at.y_m = aside_->y_m;
  const bool there = std::hypot(pose.at.x_m - aside_->x_m, pose.at.y_m - aside_->y_m) <= kThereM;
  if (there || going_ >= kLongestAside || !Sees(*aside_)) {
    if (!there) place_ = pose;  // something holds it here, or its scan is lost
    aside_.reset();
    return std::nullopt;
  }
  return hold_.Command(*place_, pose, PositionHold::SecondsOf(step));
}

std::optional<navigation::Velocity> FlightHold::Descend(const navigation::Pose& pose,
                                                        Duration step) {
  place_->at.z_m = pose.at.z_m;
  if (const auto level = GoAside(pose, step)) return level;
  if (navigation::Distance(pose.at, place_->at) > kLostM) place_ = pose;  // it lands there
  const bool lower = pose.at.z_m < lowest_m_ - kStillM;
  if (lower) lowest_m_ = pose.at.z_m;
  still_ = lower ? Duration{} : still_ + step;
  const bool stands = still_ >= kStands;
  if (stands && pose.at.z_m <= kGroundToleranceM) {
    Land();
    return std::nullopt;
  }
  navigation::Velocity command = hold_.Command(*place_, pose, PositionHold::SecondsOf(step));
  const bool slowly = stands || pose.at.z_m < kSlowBelowM;
  command.z_m_s = slowly ? -kLastDescentMps : -kDescentMps;
  return command;
}

}  // namespace musher::skills
