#include "musher/modules/line_walker/line_walker.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "musher/base/break_watch.hpp"
#include "musher/base/code.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/stamp.hpp"

namespace musher::line_walker {
namespace {

constexpr std::size_t kSidePoints = 60;
constexpr std::size_t kFrontPoints = 160;
constexpr double kSamePlaceM = 0.3, kSameYawRad = 0.35;     // of a body that was stopped
constexpr Duration kOtherClock = std::chrono::seconds(60);  // such an age is none
// The motion manager could not run, and refuses for so long what may have waited.
constexpr std::int32_t kMayBeLate =
    MakeCode(cyberdog::module_code::kMotionManager, KeyCode::kTimeout);
constexpr Duration kRefusedAsLate = BreakWatch::kArriveWithin;
constexpr double kApproachPerS = 1.0;  // forward velocity for each metre to the end

std::string Ms(Duration time) {
  return std::to_string(ToMilliseconds(time)) + " ms";
}

std::string Seconds(Duration time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", ToSeconds(time));
  return text;
}

// In the frame in which `pose` is.
Pose InFrameOf(const Pose& pose, const GroundPoint& point, double heading_rad) {
  const Pose moved = Moved({pose.x_m, pose.y_m, pose.yaw_rad}, {point.x_m, point.y_m, 0}, 1);
  return {moved.x_m, moved.y_m, Wrapped(pose.yaw_rad + heading_rad)};
}

// Along the line's lane, from `pose` to the line.
double Along(const Pose& line, const Pose& pose) {
  return std::cos(line.yaw_rad) * (line.x_m - pose.x_m) +
         std::sin(line.yaw_rad) * (line.y_m - pose.y_m);
}

}  // namespace

CameraSet::CameraSet() {
  left = {{true, 0.22, 0.06, 0.05, M_PI / 2, 20 * kDegree, 0, 640, 480, M_PI}, 0.6};
  right = {{true, 0.22, -0.06, 0.05, -M_PI / 2, 20 * kDegree, 0, 640, 480, M_PI}, 0.6};
  front = {{false, 0.27, 0, 0.06, 0, 8 * kDegree, 0, 640, 480, 80 * kDegree}, 0.6};
}

std::string_view NameOf(End end) {
  switch (end) {
    case End::kCourseEnd:
      return "course_end";
    case End::kTimeLimit:
      return "time_limit";
    case End::kLost:
      return "lost";
    case End::kStopped:
      return "stopped";
    case End::kSilent:
      return "silent";
    case End::kRefused:
      return "refused";
  }
  return "stopped";
}

bool LineWalker::StandsThere(Time now) const {
  if (!stopped_ || track_.empty()) return false;
  if (!ended_at_ || now - *ended_at_ > rules_.time_limit) return false;
  const Pose& pose = track_.pose();
  return std::hypot(pose.x_m - stopped_->x_m, pose.y_m - stopped_->y_m) <= kSamePlaceM &&
         std::abs(Wrapped(pose.yaw_rad - stopped_->yaw_rad)) <= kSameYawRad;
}

bool LineWalker::Continues(Time now) const {
  return StandsThere(now) && end_known() && lane_.known();
}

bool LineWalker::Start(Time now) {
  if (active()) return false;
  if (!StandsThere(now)) {
    approaches_ = true;
    start_.reset();  // else what is left of the approach
  }
  if (!Continues(now)) Forget();
  stopped_.reset();
  left_ = {};
  right_ = {};
  refused_since_.reset();
  pictures_from_.reset();
  clear_at_.reset();
  picture_age_ = {};
  state_ = State::kAdjusting;
  started_at_ = now;
  ended_at_.reset();
  end_.reset();
  reason_.clear();
  framed_ = false;
  return true;
}

void LineWalker::Forget() {
  lane_.Forget();
  front_end_ = side_end_ = {};
  end_line_.reset();
  beyond_ = false;
}

void LineWalker::Stop(Time now, const std::string& why) {
  if (active()) Finish(End::kStopped, why, now);
}

void LineWalker::Finish(End end, std::string reason, Time now) {
  state_ = State::kIdle;
  ended_at_ = now;
  end_ = end;
  if (!track_.empty()) stopped_ = track_.pose();
  // In the lane it does not walk on blindly, also not at the next START.
  if (lane_.known() || left_.line_at || right_.line_at) approaches_ = false;
  reason_ = std::move(reason);
  owes_end_ = std::exchange(framed_, false);
}

void LineWalker::OnOdometry(const msg::Odometry& odometry, Time now, Duration age) {
  const OdometryTrack::Taken taken = track_.Take(odometry);
  if (taken == OdometryTrack::Taken::kInvalid) return;
  odometry_repeats_ = taken == OdometryTrack::Taken::kAgain;
  if (odometry_repeats_) return;
  odometry_age_ = age > Duration(0) && age < kOtherClock ? age : Duration(0);
  odometry_at_ = now - odometry_age_;
  if (taken == OdometryTrack::Taken::kJump) OnJump(now);
}

void LineWalker::OnJump(Time now) {
  Forget();
  if (stopped_) stopped_ = track_.pose();  // not the body has jumped, which stands
  if (!start_) return;
  start_.reset();
  if (!approaches_ || left_.line_at || right_.line_at) return;
  approaches_ = false;  // how far it has come is not known any more
  if (active()) Finish(End::kLost, "the odometry has jumped in the approach to the lines", now);
}

void LineWalker::OnLines(View view, const msg::YellowLines& lines, Time now) {
  if (!active() || Repeats(view, lines)) return;
  switch (view) {
    case View::kLeft:
      return OnSide(Side::kLeft, lines, now);
    case View::kRight:
      return OnSide(Side::kRight, lines, now);
    case View::kFront:
      return OnFront(lines, now);
  }
}

bool LineWalker::Repeats(View view, const msg::YellowLines& lines) {
  const msg::Stamp& stamp = lines.header.stamp;
  if (stamp == msg::Stamp{}) return false;  // a publisher without a clock
  return std::exchange(stamps_.at(std::size_t(view)), stamp) == stamp;
}

LineWalker::Taken LineWalker::TakenOf(const msg::YellowLines& lines, Time now) const {
  const Time usual = now - rules_.picture_delay;
  if (track_.empty() || !odometry_at_) return {usual, std::nullopt};
  const auto age = track_.AgeOf(msg::FromStamp(lines.header.stamp).count());
  if (!age) return {usual, track_.At(rules_.picture_delay)};
  const Time at = std::min(now, *odometry_at_ - *age);
  if (*age > track_.span()) return {at, std::nullopt};
  return {at, track_.At(*age)};
}

bool LineWalker::Counts(const msg::YellowLines& lines, const Taken& taken, Time now) const {
  return lines.doubt.empty() && now - taken.at <= rules_.stale;
}

void LineWalker::OnSide(Side side, const msg::YellowLines& lines, Time now) {
  const bool left = side == Side::kLeft;
  Sight& sight = left ? left_ : right_;
  const Taken taken = TakenOf(lines, now);
  sight.picture_at = std::max(sight.picture_at.value_or(taken.at), taken.at);
  picture_age_ = now - taken.at;
  if (!Counts(lines, taken, now)) return;
  if (!clear_at_ || now - *clear_at_ >= rules_.stale) pictures_from_ = now;
  clear_at_ = now;
  if (!taken.pose || beyond_) return;
  const CameraSet& cameras = rules_.cameras;
  const MountedCamera& camera = left ? cameras.left : cameras.right;
  const auto points =
      EdgeOnGround(camera, cameras.trunk_height_m, cameras.farthest_m, lines, kSidePoints);
  const Pose& pose = *taken.pose;
  const double curvature = lane_.known() ? lane_.At(pose).curvature_per_m : 0;
  const auto line = FitSideLine(points, side, rules_.fit, curvature);
  if (!line || (!lane_.known() && !lane_.MayBeFirst(*line, side))) return;
  const bool alone = !Seen(left ? right_ : left_, now);
  if (!lane_.See(pose, *line, side, alone)) return;
  sight.line_at = std::max(sight.line_at.value_or(taken.at), taken.at);
  const auto end = FindSideEnd(points, *line, side, camera, cameras.trunk_height_m,
                               rules_.lane.width_m, rules_.end);
  if (end) return SeeEnd(pose, *end, rules_.side_pictures, side_end_);
  // A line that continues beyond what looked like its end.
  const Pose far = InFrameOf(pose, {line->far_x_m, 0}, 0);
  if (Along(side_end_.line, far) < -rules_.end_jump_m) side_end_.share = 0;
}

void LineWalker::OnFront(const msg::YellowLines& lines, Time now) {
  const Taken taken = TakenOf(lines, now);
  if (!Counts(lines, taken, now) || !taken.pose || !lane_.known()) return;
  const CameraSet& cameras = rules_.cameras;
  const auto points =
      EdgeOnGround(cameras.front, cameras.trunk_height_m, cameras.farthest_m, lines, kFrontPoints);
  const Pose& pose = *taken.pose;
  const auto end = FindEndLine(points, -lane_.At(pose).heading_rad, rules_.end);
  if (end) return SeeEnd(pose, *end, rules_.end_pictures, front_end_);
  front_end_.share = 0;
}

void LineWalker::SeeEnd(const Pose& pose, const EndLine& found, int pictures, EndSight& sight) {
  if (end_known()) return;  // the rest is odometry
  const Pose line = InFrameOf(pose, found.middle, found.heading_rad);
  const bool same = sight.share > 0 && std::abs(Along(sight.line, line)) <= rules_.end_jump_m;
  sight.share = (same ? sight.share : 0) + 1.0 / pictures;
  sight.line = line;
  if (sight.share >= 1 - 1e-9) end_line_ = line;
}

void LineWalker::OnResponse(const msg::MotionServoResponse& response, Time now) {
  if (!active() || !framed_) return;
  if (response.code == kCodeOk) {
    refused_since_.reset();
    return;
  }
  if (!refused_since_) refused_since_ = now;
  refused_code_ = response.code;
}

bool LineWalker::Within(const std::optional<Time>& at, Duration time, Time now) const {
  return at && now - *at <= time;
}

bool LineWalker::Seen(const Sight& sight, Time now) const {
  return Within(sight.line_at, rules_.fresh, now);
}

bool LineWalker::ImagesReady(Time now) const {
  return Within(left_.picture_at, rules_.stale, now) ||
         Within(right_.picture_at, rules_.stale, now);
}

std::optional<InLane> LineWalker::in_lane() const {
  if (!lane_.known() || track_.empty()) return std::nullopt;
  return lane_.At(track_.pose());
}

std::optional<double> LineWalker::to_end_m() const {
  if (!end_known() || track_.empty()) return std::nullopt;
  return Along(*end_line_, track_.pose());
}

void LineWalker::CheckEnds(Time now) {
  const Duration runtime = now - started_at_;
  if (runtime >= rules_.time_limit) {
    return Finish(End::kTimeLimit, "the time limit of " + Ms(rules_.time_limit) + " is over", now);
  }
  const Duration refused =
      rules_.refused + (refused_code_ == kMayBeLate ? kRefusedAsLate : Duration(0));
  if (refused_since_ && now - *refused_since_ >= refused) {
    return Finish(End::kRefused, "the motion manager refuses with " + std::to_string(refused_code_),
                  now);
  }
  const bool waiting = runtime < rules_.start_wait && !framed_;
  if (!waiting && !Within(odometry_at_, rules_.stale, now)) {
    return Finish(End::kSilent, WhyNoOdometry(), now);
  }
  if (!waiting && !ImagesReady(now)) return Finish(End::kSilent, WhyNoPictures(), now);
  if (const auto to_end = to_end_m()) {
    if (*to_end > rules_.end_gap_m) return;  // by odometry, also where the lines have ended
    return Finish(End::kCourseEnd, "the end of the lane is reached", now);
  }
  const Duration longest = rules_.fresh + rules_.lost;
  if (waiting || (MayApproach() && Within(clear_at_, longest, now))) return;
  const bool seen = Within(left_.line_at, longest, now) || Within(right_.line_at, longest, now);
  if (!seen) {
    Finish(End::kLost, "no line is seen on either side for " + Ms(rules_.lost), now);
  }
}

std::string LineWalker::WhyNoOdometry() const {
  if (odometry_repeats_) return "the stamps of the odometry stand still for " + Ms(rules_.stale);
  if (odometry_age_ > rules_.stale) return "the odometry is " + Seconds(odometry_age_) + " old";
  return "no odometry for " + Ms(rules_.stale);
}

std::string LineWalker::WhyNoPictures() const {
  const std::string what = "no pictures of the left and right line for " + Ms(rules_.stale);
  if (picture_age_ <= rules_.stale) return what;
  return what + ": the last one was " + Seconds(picture_age_) + " old";
}

bool LineWalker::MayApproach() const {
  if (!approaches_ || rules_.approach_m <= 0 || track_.empty()) return false;
  if (left_.line_at || right_.line_at) return false;
  const Pose& pose = track_.pose();
  return !start_ || std::hypot(pose.x_m - start_->x_m, pose.y_m - start_->y_m) < rules_.approach_m;
}

// Detectors that have just begun to look get the time of `stale` to see a line.
bool LineWalker::Approaching(Time now) const {
  return MayApproach() && clear_at_ && now - *clear_at_ < rules_.stale &&
         now - *pictures_from_ >= rules_.stale;
}

InLane LineWalker::AlongStart(const Pose& pose) const {
  const double aside_m = std::cos(start_->yaw_rad) * (pose.y_m - start_->y_m) -
                         std::sin(start_->yaw_rad) * (pose.x_m - start_->x_m);
  return {aside_m, Wrapped(pose.yaw_rad - start_->yaw_rad), 0};
}

std::optional<LineWalker::Step> LineWalker::EndFrame() {
  if (!std::exchange(owes_end_, false)) return std::nullopt;
  return Step{{}, true};
}

std::optional<LineWalker::Step> LineWalker::Tick(Time now) {
  if (active()) CheckEnds(now);
  // The frame of a walk that has ended comes before those of the next one.
  if (owes_end_ || !active()) return EndFrame();
  const bool moves = Within(odometry_at_, rules_.stale, now);
  if (moves && Approaching(now)) {
    if (!start_) start_ = track_.pose();
    state_ = State::kAdjusting;
    framed_ = true;
    return Step{Steer(AlongStart(track_.pose()), rules_.lost_m_s, rules_.steering), false};
  }
  const bool ready = moves && lane_.known() && ImagesReady(now);  // also where it continues a walk
  if (!ready && !framed_) return std::nullopt;                    // it stands
  if (!ready) {
    state_ = State::kAdjusting;
    return Step{};
  }
  framed_ = true;
  return Step{Command(now), false};
}

Velocity LineWalker::Command(Time now) {
  const auto to_end = to_end_m();
  if (to_end && *to_end <= 0 && !std::exchange(beyond_, true)) lane_.Straighten(track_.pose());
  const Pose then = Moved(track_.pose(), track_.velocity(), ToSeconds(rules_.lead));
  const InLane in_lane = lane_.At(then);
  const bool seen = Seen(left_, now) || Seen(right_, now);
  double at_most = seen || to_end ? rules_.steering.forward_m_s : rules_.lost_m_s;
  if (to_end) {
    const double gap = std::max(0.0, *to_end - rules_.end_gap_m);
    at_most = std::min(at_most, std::max(rules_.steering.slow_m_s, kApproachPerS * gap));
  }
  const bool beside = std::abs(in_lane.offset_m) > rules_.adjust_m ||
                      std::abs(in_lane.heading_rad) > rules_.adjust_rad;
  state_ = beside || !(seen || to_end) ? State::kAdjusting : State::kWalking;
  return Steer(in_lane, at_most, rules_.steering);
}

Duration LineWalker::Runtime(Time now) const {
  if (active()) return now - started_at_;
  return ended_at_ ? *ended_at_ - started_at_ : Duration(0);
}

std::string LineWalker::StatusText(Time now) const {
  const char* const state = state_ == State::kIdle      ? "IDLE"
                            : state_ == State::kWalking ? "WALKING"
                                                        : "ADJUSTING";
  char runtime[32];
  std::snprintf(runtime, sizeof runtime, "%.1fs", ToSeconds(Runtime(now)));
  std::string text = std::string("State:") + state + ",Active:" + (active() ? "True" : "False") +
                     ",ImagesReady:" + (ImagesReady(now) ? "True" : "False") +
                     ",Runtime:" + runtime;
  if (end_) text += ",End:" + std::string(NameOf(*end_));
  return text;
}

}  // namespace musher::line_walker
