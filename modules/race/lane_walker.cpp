#include "musher/modules/race/lane_walker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/race/printable.hpp"

namespace musher::race {
namespace {

// The end of an earlier walk may be in the statuses for so long after START. A good one is never
// that of a walker that has not begun.
constexpr Duration kOldEnd = Milliseconds(1000);
// A walker that has not begun so long after START has not received it, or ignores it.
constexpr Duration kLatestBegin = Milliseconds(5000);

// The end of a walk that a STOP has ended, an emergency stop, or a state other than Active.
constexpr std::string_view kStopped = "stopped";
// And of one whose process has ended: the new one does not know the lane, and would approach it
// without a line.
constexpr std::string_view kRestarted = "no walk: it was restarted";

// Of odometry: a sample that is older says nothing of the present place, and one that is farther
// from the one before than a body moves is a jump.
constexpr double kPlaceJumpM = 0.1;
constexpr double kBodyMS = 3;

// Never shorter than what the course takes for fresh.
Duration LatestPlace(const OdometryRules& rules) {
  return std::max<Duration>(Milliseconds(1000), 3 * rules.fresh);
}

double DistanceM(const navigation::Pose& from, const navigation::Pose& to) {
  return std::hypot(to.at.x_m - from.at.x_m, to.at.y_m - from.at.y_m);
}

// The value of ",End:<reason>"; empty: none.
std::string_view EndOf(std::string_view status) {
  constexpr std::string_view kKey = ",End:";
  const std::size_t at = status.find(kKey);
  if (at == std::string_view::npos) return {};
  const std::string_view value = status.substr(at + kKey.size());
  return value.substr(0, value.find(','));
}

}  // namespace

void LaneWalker::Begin(Index walk, const LaneProgress& progress) {
  walk_ = walk;
  started_ = false;
  walked_ = progress.walked;
  from_ = progress.from;
  place_.reset();
  lost_ = progress.lost;
  arrived_ = false;
  tries_ = 0;
  retry_at_.reset();
}

bool LaneWalker::arrived() const {
  if (!walk_) return false;
  return arrived_ || (started_ && running_ && end_ == course_.walks[*walk_].end);
}

LaneWalker::End LaneWalker::Advance(Duration now, std::string& reason) {
  const LaneWalk& walk = course_.walks[*walk_];
  if (arrived()) return End::kGood;
  if (!started_ && retry_at_ && now < *retry_at_) return End::kNone;
  if (!std::exchange(started_, true)) {
    retry_at_.reset();
    started_at_ = received_at_ = now;
    received_ = running_ = false;
    end_.clear();
    ended_at_.reset();
    outputs_.CommandWalker(walk, true);
    return End::kNone;
  }
  if (std::exchange(received_, false)) received_at_ = now;
  if (!from_ && now - started_at_ >= LatestPlace(course_.odometry))
    lost_ = true;  // a later pose is not of its begin
  const bool good = end_ == walk.end;
  const bool ended = !end_.empty() && !good && (running_ || now - started_at_ >= kOldEnd);
  if (ended) {
    if (!ended_at_) ended_at_ = now;
    if (now - *ended_at_ < kStopGrace) return End::kNone;
    reason = "the line walker has ended with " + Printable(end_);
    // The race has sent no STOP.
    const bool by_others = running_ && (end_ == kStopped || end_ == kRestarted);
    if (by_others || tries_ >= walk.retries) return End::kOther;
    reason += ": retry " + std::to_string(++tries_) + " of " + std::to_string(walk.retries);
    Pause();
    retry_at_ = now + walk.retry_after;
    return End::kNone;
  }
  ended_at_.reset();
  if (!running_ && now - started_at_ >= kLatestBegin && now - received_at_ < walk.silent) {
    reason = "the line walker has not begun to walk within " +
             std::to_string(ToMilliseconds(kLatestBegin)) + " ms of its START";
    return End::kOther;
  }
  if (now - received_at_ >= walk.silent) {
    reason = "no " + walk.status + " for " + std::to_string(ToMilliseconds(walk.silent)) +
             " ms: the line walker is lost";
    return End::kLost;
  }
  if (walked_ + (now - started_at_) < walk.limit) return End::kNone;
  reason = "the line walker has not reached the end within " +
           std::to_string(ToMilliseconds(walk.limit)) + " ms";
  return End::kOther;
}

void LaneWalker::Stop() {
  if (!walk_) return;
  if (std::exchange(started_, false)) outputs_.CommandWalker(course_.walks[*walk_], false);
  walk_.reset();
}

void LaneWalker::Pause() {
  arrived_ = arrived();
  if (!walk_ || !std::exchange(started_, false)) return;
  walked_ += received_at_ > started_at_ ? received_at_ - started_at_ : Duration(0);
  outputs_.CommandWalker(course_.walks[*walk_], false);
}

LaneProgress LaneWalker::Interrupt() {
  Pause();
  walk_.reset();
  return {walked_, from_, lost_};
}

void LaneWalker::OnOdometry(const navigation::Pose& pose, Time time) {
  if (!walk_) return;
  if (place_) {
    const double most_m = kPlaceJumpM + kBodyMS * ToSeconds(time - place_->at);
    if (DistanceM(place_->pose, pose) > most_m) lost_ = true;
  }
  place_ = Place{pose, time};
  if (!from_) from_ = pose;
}

std::optional<double> LaneWalker::WayM(Time time) const {
  if (lost_ || !from_ || !place_ || time - place_->at > LatestPlace(course_.odometry))
    return std::nullopt;
  return DistanceM(*from_, place_->pose);
}

void LaneWalker::OnStatus(Index walk, std::string_view status) {
  if (walk_ != walk || !started_) return;
  received_ = true;
  end_ = EndOf(status);
  if (!end_.empty()) return;
  const bool idle = status.find("Active:False") != std::string_view::npos;
  if (!idle) running_ = true;
  if (idle && running_) end_ = kRestarted;
}

}  // namespace musher::race
