#include "musher/lifecycle/ros2/bond.hpp"

#include <algorithm>

namespace musher {
namespace {

constexpr Duration kEndTimeout = std::chrono::seconds(2);
// The limits of the timeout that the other side publishes.
constexpr Duration kShortestTimeout = Milliseconds(200);
constexpr Duration kLongestTimeout = std::chrono::minutes(10);

}  // namespace

bool Bond::Publish(Time now) {
  publish_at_ = now + kPeriod;
  return true;
}

bool Bond::Start(Time now) {
  if (active()) return false;
  phase_ = Phase::kWaiting;
  other_.clear();
  return Publish(now);
}

bool Bond::Stop(Time now) {
  switch (phase_) {
    case Phase::kFormed:
      phase_ = Phase::kEnding;
      ended_by_ = now + kEndTimeout;
      return Publish(now);
    case Phase::kWaiting:
      phase_ = Phase::kOff;
      return true;
    case Phase::kBroken:
      phase_ = Phase::kOff;
      return false;
    default:
      return false;
  }
}

bool Bond::OnHeartbeat(const BondHeartbeat& heartbeat, Time now) {
  if (phase_ == Phase::kOff) return false;
  if (phase_ == Phase::kEnding) {
    if (heartbeat.active) return false;
    phase_ = Phase::kOff;
    return false;
  }
  if (!heartbeat.active) {
    const bool of_this_bond = other_.empty() || heartbeat.instance == other_;
    if (phase_ == Phase::kBroken || !of_this_bond) return false;
    phase_ = Phase::kBroken;
    return true;  // the other side waits for this reply
  }
  const bool is_new = phase_ != Phase::kFormed || heartbeat.instance != other_;
  phase_ = Phase::kFormed;
  other_ = heartbeat.instance;
  heartbeat_by_ = now + std::clamp(heartbeat.timeout, kShortestTimeout, kLongestTimeout);
  return is_new && Publish(now);
}

bool Bond::OnReaders(Time now) {
  return active() && Publish(now);
}

bool Bond::OnTime(Time now) {
  if (phase_ == Phase::kFormed && now >= heartbeat_by_) {
    phase_ = Phase::kBroken;
    return true;
  }
  if (phase_ == Phase::kEnding && now >= ended_by_) {
    phase_ = Phase::kOff;
    return false;
  }
  const bool publishes = active() || phase_ == Phase::kEnding;
  return publishes && now >= publish_at_ && Publish(now);
}

std::optional<Time> Bond::next() const {
  switch (phase_) {
    case Phase::kWaiting:
      return publish_at_;
    case Phase::kFormed:
      return std::min(publish_at_, heartbeat_by_);
    case Phase::kEnding:
      return std::min(publish_at_, ended_by_);
    default:
      return std::nullopt;
  }
}

}  // namespace musher
