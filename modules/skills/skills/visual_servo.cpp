#include "musher/modules/skills/skills/visual_servo.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::skills {
namespace {

constexpr int kAgreeing = 2;              // sightings in a row, before it moves
constexpr double kFarthestM = 1000;       // what is farther away is no sighting
constexpr double kTargetMPerS = 2;        // a target is not faster
constexpr double kErrorM = 0.15;          // of two sightings at one place,
constexpr double kErrorShare = 0.1;       // and this share of the distance
constexpr double kJumpBackS = 0.5;        // after a jump, so long's move counts at most
constexpr double kByDistance = 0.8;       // m/s for a metre
constexpr double kByBearing = 1.5;        // rad/s for a radian
constexpr double kStraightRad = 0.5;      // with more it turns on the spot
constexpr double kBackwardsMPerS = 0.15;  // at most
constexpr double kInnerShare = 0.6;       // of a tolerance, until which it corrects
constexpr std::size_t kRightLooks = 5;    // and for kRightTime, before it is reached
constexpr Duration kRightTime = std::chrono::milliseconds(500);

double Apart(const navigation::Point& a, const navigation::Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

}  // namespace

double LevelDistanceTo(const navigation::Point& target) {
  return std::hypot(target.x_m, target.y_m);
}

double BearingOf(const navigation::Point& target) {
  return std::atan2(target.y_m, target.x_m);
}

double VisualServo::FarthestMove(double seconds) const {
  const double away_m = LevelDistanceTo(last_->at);
  const double own_m_s = rules_.speed_m_s + rules_.turn_rad_s * away_m;
  return kErrorM + kErrorShare * away_m + seconds * (kTargetMPerS + own_m_s);
}

void VisualServo::Doubt(std::string why) {
  doubt_ = std::move(why);
  agree_ = 0;
}

void VisualServo::Take(const Look& look) {
  looked_ = look.at;
  if (look.seen.empty()) return;  // missed once: the last sighting gets old
  for (const navigation::Point& at : look.seen) {
    const double away_m = LevelDistanceTo(at);
    if (navigation::IsFinite(at) && away_m > 0 && away_m <= kFarthestM) continue;
    return Doubt("the place of " + rules_.target + " is none");
  }
  const navigation::Point& at = look.seen.front();
  if (look.seen.size() > 1) {
    return Doubt(fmt::format("{} things are {}, {:.2f} m and {:.2f} m away", look.seen.size(),
                             rules_.target, LevelDistanceTo(at), LevelDistanceTo(look.seen[1])));
  }
  if (last_) {
    double seconds = ToSeconds(look.at - last_->time);
    if (jumped_) seconds = std::min(seconds, kJumpBackS);
    const double moved_m = Apart(at, last_->at);
    if (moved_m > FarthestMove(seconds)) {
      if (jumped_) return;  // the first jump is the reason
      jumped_ = true;
      return Doubt(
          fmt::format("{} has jumped by {:.2f} m within {:.2f} s, farther than it can move",
                      rules_.target, moved_m, seconds));
    }
    if (look.at - last_->time > kSightingCounts) agree_ = 0;
  }
  doubt_.clear();
  jumped_ = false;
  last_ = Sighting{at, look.at};
  ++agree_;
}

std::string VisualServo::WhyStand(Time now) const {
  if (!doubt_.empty()) return doubt_;
  if (!last_) return rules_.target + " is not seen";
  const Duration age = now - last_->time;
  if (age < Duration::zero()) return "the sightings of " + rules_.target + " are of another time";
  if (age > kSightingCounts) {
    return fmt::format("{} is not seen for {:.1f} s; it was {:.2f} m away", rules_.target,
                       ToSeconds(age), LevelDistanceTo(last_->at));
  }
  return agree_ < kAgreeing ? rules_.target + " was seen only once" : "";
}

ServoStep VisualServo::Update(const std::optional<Look>& look, const std::string& why_none,
                              bool stands, Time now) {
  const bool is_new = look && look->at <= now && (!looked_ || look->at > *looked_);
  if (is_new) Take(*look);
  const std::string why = look ? WhyStand(now) : why_none;
  if (why.empty()) return Decide(stands);
  rests_ = false;
  ServoStep step{.kind = ServoStep::Kind::kStands, .why = why};
  if (last_) step.target = last_->at;
  return step;
}

bool VisualServo::IsRight(const navigation::Point& target, double share) const {
  const double off_rad = navigation::Wrapped(BearingOf(target) - rules_.bearing_rad);
  return std::abs(LevelDistanceTo(target) - rules_.distance_m) <= share * rules_.tolerance_m &&
         std::abs(off_rad) <= share * rules_.bearing_tolerance_rad;
}

ServoStep VisualServo::Decide(bool stands) {
  if (!IsRight(last_->at, rests_ ? 1 : kInnerShare)) {
    rests_ = false;
    return {.kind = ServoStep::Kind::kMoves, .command = Command(), .target = last_->at};
  }
  if (!std::exchange(rests_, true)) right_.clear();
  if (!stands) right_.clear();
  if (stands && (right_.empty() || last_->time > right_.back().time)) right_.push_back(*last_);
  ServoStep step{.kind = ServoStep::Kind::kSettles, .target = last_->at};
  const bool long_enough =
      right_.size() >= kRightLooks && right_.back().time - right_.front().time >= kRightTime;
  if (!long_enough) return step;
  navigation::Point mean;
  for (const Sighting& sighting : right_) {
    const double share = 1.0 / static_cast<double>(right_.size());
    mean.x_m += share * sighting.at.x_m;
    mean.y_m += share * sighting.at.y_m;
    mean.z_m += share * sighting.at.z_m;
  }
  step.kind = ServoStep::Kind::kReached;
  step.target = mean;
  return step;
}

navigation::Velocity VisualServo::Command() {
  const double off_m = LevelDistanceTo(last_->at) - rules_.distance_m;
  const double bearing_rad = BearingOf(last_->at);
  near_ = std::abs(off_m) <= (near_ ? 1 : kInnerShare) * rules_.tolerance_m;
  const double turn_rad =
      near_ ? navigation::Wrapped(bearing_rad - rules_.bearing_rad) : bearing_rad;
  navigation::Velocity command;
  command.yaw_rad_s = std::clamp(kByBearing * turn_rad, -rules_.turn_rad_s, rules_.turn_rad_s);
  if (near_ || std::abs(bearing_rad) > kStraightRad) return command;
  const double backwards_m_s = std::min(kBackwardsMPerS, rules_.speed_m_s);
  command.x_m_s =
      std::cos(bearing_rad) * std::clamp(kByDistance * off_m, -backwards_m_s, rules_.speed_m_s);
  return command;
}

}  // namespace musher::skills
