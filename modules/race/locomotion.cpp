#include "musher/modules/race/locomotion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

#include "musher/base/break_watch.hpp"
#include "musher/base/code.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"  // names modules in texts
#include "musher/messages/protocol/motion.hpp"

namespace musher::race {
namespace {

constexpr double kMostSeconds = 60;  // of a walk, between two samples of odometry
// A walk of so long that comes less far than OdometryRules::blocked_share is blocked.
constexpr Duration kLatestMove = Milliseconds(1500);
// The slip of a way is known after so long a walk, and forgotten with about this time.
constexpr Duration kLeastOfWay = Milliseconds(2000);
constexpr Duration kMostOfWay = std::chrono::seconds(30);
// A body without a frame for so long stands: the motion manager ends the stream.
constexpr Duration kLongestFrame = Milliseconds(200);
// The motion manager could not run, and refuses for so long what may have waited.
constexpr std::int32_t kMayBeLate =
    MakeCode(cyberdog::module_code::kMotionManager, KeyCode::kTimeout);
constexpr Duration kRefusedAsLate = BreakWatch::kArriveWithin;
constexpr int kBadReports = 3;  // in a row: 0.3 s of motion_status
constexpr Index kSwitchNames = 15;

// Of MotionStatus::switch_status.
constexpr std::array<std::string_view, kSwitchNames> kBodyStates{
    "normal",        "transitioning",  "emergency stop",        "damping",       "lifted",
    "no transition", "over heat",      "low battery",           "fallen",        "a foot is wrong",
    "stuck",         "a motor is hot", "a motor is overloaded", "a motor fault", "charging"};

Duration Times(Duration time, double factor) {
  return Duration(std::llround(static_cast<double>(time.count()) * factor));
}

// A distance of a walk in metres, or in degrees of a turn.
std::string DistanceText(const Movement& movement, double seconds) {
  const Twist& twist = movement.twist;
  const double speed = twist.turns() ? std::abs(twist.yaw_rad_s) * 180 / M_PI
                                     : std::hypot(twist.forward_m_s, twist.left_m_s);
  char text[64];
  std::snprintf(text, sizeof text, twist.turns() ? "%.0f degrees" : "%.2f m",
                speed * movement.odometry_share * seconds);
  return text;
}

std::string BodyState(int status) {
  const auto index = static_cast<Index>(status);
  const std::string name =
      index < kBodyStates.size() ? std::string(kBodyStates[index]) : std::string("unknown");
  return name + " (switch_status " + std::to_string(status) + ")";
}

}  // namespace

void Locomotion::Walk(const Stretch& stretch) {
  const Duration length = stretch.count * course_.step;
  const double share = course_.odometry.used() ? course_.odometry.most_share : 1;
  Continue({.movement = stretch.movement, .length = length, .limit = Times(length, share)});
}

void Locomotion::WalkAtMost(const Stretch& stretch) {
  const Duration length = stretch.count * course_.step;
  Continue({.movement = stretch.movement, .length = length, .limit = length});
}

void Locomotion::Continue(const WalkProgress& walk) {
  EndStream();
  motion_.reset();
  walk_ = walk;
  steer_rad_s_ = 0;
  static_cast<void>(Rise({}));
}

bool Locomotion::Rise(Duration now) {
  if (lying_ && !stands_) stands_ = Motion{course_.stand, Stage::kCall, now, 0, {}};
  return stands_.has_value();
}

void Locomotion::Move(Index movement, Duration now) {
  EndStream();
  walk_.reset();
  motion_ = Motion{movement, Stage::kBefore, now, 0, {}};
}

bool Locomotion::Advance(Duration now, Time time) {
  if (walk_) return AdvanceWalk(now, time);
  if (!motion_) return true;
  if (!AdvanceMotion(*motion_, now)) return false;
  motion_.reset();
  return true;
}

bool Locomotion::AdvanceWalk(Duration now, Time time) {
  if (busy() || stands_) return false;  // the body is not free yet
  if (!streaming_) {
    streaming_ = true;
    stream_from_ = body_received_at_ = now;
    refused_from_.reset();
    refused_ = false;
    odometer_.Begin(now);
  } else if (refused_ && refused_code_ == kMayBeLate) {
    stream_from_ = now;  // the body stands yet
    odometer_.Begin(now);
  } else {
    CountProgress(now);
  }
  frame_at_ = now;
  lying_ = false;
  if (walk_->left() > Duration(0) && walk_->walked < walk_->limit) {
    Send(false);
    return false;
  }
  EndStream();
  ended_walk_ = *walk_;
  walk_.reset();
  walked_until_ = time;
  CompareWithTime(ended_walk_);
  return true;
}

// The body takes up a speed slowly, and gives it up as slowly after the end: both are left to time.
void Locomotion::CountProgress(Duration now) {
  const Duration passed = std::min(now - frame_at_, kLongestFrame);
  walk_->walked += passed;
  unmeasured_ += passed;
  if (!course_.odometry.used()) return Measure(std::exchange(unmeasured_, {}));
  const Movement& movement = course_.movements[walk_->movement];
  const Twist& twist = movement.twist;
  const bool begins = now - stream_from_ <= course_.odometry.begin;
  const bool by_time = begins || !odometer_.believed() || twist == Twist{};
  const auto moved = odometer_.Take(now);
  if (moved && !twist.turns()) CountTurn(moved->yaw_rad);
  const bool checks = course_.odometry.blocked_share > 0 && twist != Twist{};
  if (checks && odometer_.still() >= kLatestMove) {
    Fail(movement.name +
         ": the pose of the odometry stands still: something is in the way, or it is frozen");
  }
  if (by_time || !odometer_.believed()) return Measure(ByTime(std::exchange(unmeasured_, {})));
  if (!moved) {
    // A pose that stands still has its next sample to say how far it was.
    if (odometer_.still() > Duration(0)) {
      unmeasured_ = std::min(unmeasured_, course_.odometry.fresh);
    }
    return Measure({});
  }
  const double speed = std::hypot(twist.forward_m_s, twist.left_m_s);
  const double seconds =
      twist.turns() ? moved->yaw_rad / twist.yaw_rad_s
                    : (moved->forward_m * twist.forward_m_s + moved->left_m * twist.left_m_s) /
                          (speed * speed);
  const double counted = std::clamp(seconds / movement.odometry_share, -kMostSeconds, kMostSeconds);
  const Duration distance = Times(std::chrono::seconds(1), counted);
  WaySums& sums = ways_.at(static_cast<std::size_t>(WayOf(twist)));
  sums.walked += std::exchange(unmeasured_, {});
  sums.measured += distance;
  if (sums.walked > kMostOfWay) sums = {sums.walked / 2, sums.measured / 2};
  Measure(distance);
  FailIfBlocked(movement);
}

Locomotion::Way Locomotion::WayOf(const Twist& twist) {
  if (twist.turns()) return Way::kTurn;
  return std::abs(twist.left_m_s) > std::abs(twist.forward_m_s) ? Way::kAside : Way::kAhead;
}

double Locomotion::ShareOf(Way way) const {
  const WaySums& sums = ways_.at(static_cast<std::size_t>(way));
  if (sums.walked < kLeastOfWay) return 1;
  const OdometryRules& rules = course_.odometry;
  return std::clamp(ToSeconds(sums.measured) / ToSeconds(sums.walked), 1 / rules.most_share,
                    1 / rules.least_share);
}

Duration Locomotion::ByTime(Duration time) const {
  const Twist& twist = course_.movements[walk_->movement].twist;
  return twist == Twist{} ? time : Times(time, ShareOf(WayOf(twist)));
}

std::string Locomotion::SlipText() const {
  constexpr std::array<const char*, 3> kNames{"ahead", "aside", "of a turn"};
  std::string all;
  for (std::size_t i = 0; i < ways_.size(); ++i) {
    if (ways_.at(i).walked < kLeastOfWay) continue;
    char text[48];
    std::snprintf(text, sizeof text, "%.2f %s", ShareOf(static_cast<Way>(i)), kNames.at(i));
    all += (all.empty() ? "" : ", ") + std::string(text);
  }
  return all;
}

void Locomotion::CountTurn(double yaw_rad) {
  walk_->turned_rad += yaw_rad;
  const double most_rad = course_.odometry.most_turned_rad;
  if (most_rad == 0 || std::abs(walk_->turned_rad) <= most_rad) return;
  const auto degrees = std::lround(std::abs(walk_->turned_rad) * 180 / M_PI);
  Fail(course_.movements[walk_->movement].name + " has turned by " + std::to_string(degrees) +
       " degrees by odometry: it has lost its way");
}

void Locomotion::Measure(Duration distance) {
  walk_->measured += distance;
  const OdometryRules& rules = course_.odometry;
  walk_->made = rules.used()
                    ? std::clamp(walk_->measured, Times(walk_->walked, 1 / rules.most_share),
                                 Times(walk_->walked, 1 / rules.least_share))
                    : walk_->measured;
}

void Locomotion::FailIfBlocked(const Movement& movement) {
  const double share = course_.odometry.blocked_share;
  if (share == 0 || walk_->walked < kLatestMove) return;
  if (walk_->measured >= Times(walk_->made, share)) return;
  Fail(movement.name + " has made " + DistanceText(movement, ToSeconds(walk_->measured)) + " of " +
       DistanceText(movement, ToSeconds(walk_->walked)) + " by odometry: something is in the way");
}

void Locomotion::CompareWithTime(const WalkProgress& walk) {
  if (walk.measured == walk.made) return;
  const Movement& movement = course_.movements[walk.movement];
  const bool less = walk.measured < walk.made;
  const Duration wanted = less ? walk.length : walk.walked;
  const auto steps = (wanted + course_.step / 2) / course_.step;
  difference_ =
      movement.name + ": " + std::to_string(steps) + " steps made " +
      DistanceText(movement, ToSeconds(walk.measured)) + " of " +
      DistanceText(movement, ToSeconds(wanted)) + " by odometry: " +
      (less ? "the feet slip, or something is in the way" : "it shows more than the feet can walk");
}

void Locomotion::Send(bool end) {
  const Movement& movement = course_.movements[walk_->movement];
  Twist twist = end ? Twist{} : movement.twist;
  if (!end) twist.yaw_rad_s += steer_rad_s_;
  outputs_.Walk({movement.motion_id, twist, movement.step_height_m, end});
}

void Locomotion::EndStream() {
  if (!std::exchange(streaming_, false)) return;
  Measure(ByTime(std::exchange(unmeasured_, {})));
  Send(true);
}

WalkProgress Locomotion::Stop() {
  EndStream();
  const WalkProgress walk = walk_.value_or(WalkProgress{});
  walk_.reset();
  motion_.reset();
  stands_.reset();
  return walk;
}

bool Locomotion::ahead() const {
  return walk_ && course_.movements[walk_->movement].twist.forward_m_s > 0;
}

bool Locomotion::AdvanceMotion(Motion& motion, Duration now) {
  const Movement& movement = course_.movements[motion.movement];
  if (motion.stage == Stage::kBefore && now - motion.since >= movement.before) {
    motion.stage = Stage::kCall;
  }
  if (motion.stage == Stage::kCall && !busy()) {
    motion.stage = Stage::kReply;
    motion.call = ++calls_;
    call_ = Call{motion.call, movement.limit, now, motion.movement, false};
    outputs_.Move(movement.motion_id, motion.call);
  }
  if (motion.stage == Stage::kAfter || motion.stage == Stage::kFailed) {
    if (motion.since == Duration(-1)) motion.since = now;  // the reply came since the last tick
  }
  if (motion.stage == Stage::kFailed && now - motion.since >= kStopGrace) Fail(motion.why);
  return motion.stage == Stage::kAfter && now - motion.since >= movement.after;
}

void Locomotion::ExpireCall(Duration now) {
  if (!call_ || now - call_->since < call_->limit) return;
  OnMotionDone(call_->number,
               Error{kCodeTimeout,
                     "no reply within " + std::to_string(ToMilliseconds(call_->limit)) + " ms"});
}

void Locomotion::OnMotionDone(std::uint64_t number, const Result<>& done) {
  if (!call_ || call_->number != number) return;
  const Call call = *std::exchange(call_, std::nullopt);
  const Movement& movement = course_.movements[call.movement];
  const bool lies_down = movement.motion_id == msg::MotionId::kGetDown;
  if (done || lies_down) lying_ = lies_down;  // one that failed may have laid it down in part
  Motion* waiting = nullptr;
  if (motion_ && motion_->call == number) waiting = &*motion_;
  if (stands_ && stands_->call == number) waiting = &*stands_;
  if (waiting == nullptr) return;  // the motion was dropped
  if (done) {
    waiting->stage = Stage::kAfter;
    waiting->since = Duration(-1);
  } else if (call.paused || paused_) {
    waiting->stage = Stage::kCall;
    if (!paused_ && stands_again_ && motion_ && waiting == &*motion_) StandFirst({});
  } else {
    waiting->stage = Stage::kFailed;
    waiting->since = Duration(-1);
    waiting->why = "the motion " + movement.name + " (" + std::to_string(movement.motion_id) +
                   ") failed: " + ErrorText(done.error());
  }
}

void Locomotion::Pause() {
  paused_ = true;
  EndStream();
  stands_.reset();
  if (call_) call_->paused = true;
  if (motion_ && motion_->stage == Stage::kFailed) motion_->stage = Stage::kCall;
}

void Locomotion::Resume(bool stand, Duration now) {
  paused_ = false;
  bad_reports_ = 0;
  stands_again_ = stand;
  if (stand) {
    StandFirst(now);
  } else {
    lying_ = true;  // perhaps, by an emergency stop or another program
  }
}

// Clears the latch of an emergency stop, too, which refuses every other motion, also that of a
// lying robot. A motion that has not been answered yet may have ended well.
void Locomotion::StandFirst(Duration now) {
  const bool begins =
      motion_ && (motion_->stage == Stage::kBefore || motion_->stage == Stage::kCall);
  const bool stands = motion_ && motion_->movement == course_.stand;
  const bool needed = motion_ ? begins && !stands : !lying_;
  if (needed) stands_ = Motion{course_.stand, Stage::kCall, now, 0, {}};
}

bool Locomotion::AdvanceStanding(Duration now) {
  if (!stands_) return true;
  if (!AdvanceMotion(*stands_, now)) return false;
  stands_.reset();
  return true;
}

void Locomotion::OnBody(int switch_status, int motion_id) {
  body_received_ = true;
  const bool silent = motion_id < 0;
  if (!silent && switch_status <= msg::MotionStatus::kTransitioning) {
    bad_reports_ = 0;
    return;
  }
  ++bad_reports_;
  bad_ = silent ? "the motion board is silent" : "the body reports: " + BodyState(switch_status);
}

void Locomotion::OnServoReply(bool accepted, std::int32_t code) {
  refused_ = !accepted;
  refused_code_ = code;
}

std::optional<std::string> Locomotion::Fault(Duration now) {
  ExpireCall(now);
  if (fault_) return std::exchange(fault_, std::nullopt);
  if (std::exchange(body_received_, false)) body_received_at_ = now;
  // A motion reports its own failure: a fallen body stands up by one.
  const bool moves = motion_ || stands_ || busy();
  if (moves) bad_reports_ = std::min(bad_reports_, kBadReports - 1);
  if (!moves && bad_reports_ >= kBadReports) {
    bad_reports_ = 0;
    return bad_;
  }
  if (!streaming_) return std::nullopt;
  if (course_.body.silent > Duration(0) && now - body_received_at_ >= course_.body.silent) {
    return "no motion_status for " + std::to_string(ToMilliseconds(course_.body.silent)) +
           " ms: the motion manager is lost";
  }
  if (!refused_) {
    refused_from_.reset();
    return std::nullopt;
  }
  if (!refused_from_) refused_from_ = now;
  const Duration extra = refused_code_ == kMayBeLate ? kRefusedAsLate : Duration(0);
  if (now - *refused_from_ < course_.body.refused + extra) return std::nullopt;
  return "the motion manager refuses to walk: " + CodeText(refused_code_);
}

}  // namespace musher::race
