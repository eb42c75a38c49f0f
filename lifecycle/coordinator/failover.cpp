#include "musher/lifecycle/coordinator/failover.hpp"

#include <algorithm>
#include <utility>

namespace musher {
namespace {

// A voter whose heartbeats do not arrive for so long says nothing. With several hosts they are due
// every 125 ms.
constexpr Duration kSilent = Milliseconds(1000);
// Two looks of a standby are at most so far apart, unless its process could not run.
constexpr Duration kBreak = Milliseconds(500);

bool IsMajority(std::size_t count, std::size_t all) {
  return 2 * count > all;
}

std::string Of(std::size_t count, std::size_t all) {
  return std::to_string(count) + " of " + std::to_string(all) + " actuators that vote";
}

}  // namespace

std::vector<ActuatorIndex> Voters(const MachineConfig& config) {
  std::vector<ActuatorIndex> all;
  std::vector<ActuatorIndex> critical;
  for (const ActuatorIndex i : config.actuators.Indices()) {
    if (config.actuators[i].protocol != Protocol::kMusher) continue;
    all.push_back(i);
    if (config.actuators[i].critical) critical.push_back(i);
  }
  return critical.empty() ? all : critical;
}

StandbyDecision::StandbyDecision(const MachineConfig& config, Time now)
    : after_(*config.failover), controller_at_(now), looked_at_(now) {
  for (const ActuatorIndex i : Voters(config)) voters_.push_back({i, std::nullopt, std::nullopt});
}

void StandbyDecision::OnController(Time now) {
  controller_at_ = now;
}

void StandbyDecision::OnActuator(ActuatorIndex actuator, bool controller_lost, Time now) {
  const auto voter = std::ranges::find(voters_, actuator, &Voter::actuator);
  if (voter == voters_.end()) return;
  const bool was_silent = !voter->received || now - *voter->received > kSilent;
  voter->received = now;
  if (!controller_lost) {
    voter->lost_since.reset();
  } else if (was_silent || !voter->lost_since) {
    voter->lost_since = now;
  }
}

bool StandbyDecision::HasLost(const Voter& voter, Time now) const {
  return voter.received && now - *voter.received <= kSilent && voter.lost_since &&
         now - *voter.lost_since >= after_;
}

std::string StandbyDecision::WhyNot(Time now) {
  if (now - std::exchange(looked_at_, now) > kBreak) {
    controller_at_ = now;
    for (Voter& voter : voters_) voter.lost_since.reset();
  }
  if (now - controller_at_ < after_) return "a controller leads, or has led until just now";
  const auto lost = static_cast<std::size_t>(
      std::ranges::count_if(voters_, [&](const Voter& voter) { return HasLost(voter, now); }));
  if (IsMajority(lost, voters_.size())) return "";
  return "no controller is received, and only " + Of(lost, voters_.size()) +
         " report here that they have lost theirs";
}

std::string MajorityReach::WhyRelease(const MachineConfig& config, const Machine& machine,
                                      Time now) {
  const std::vector<ActuatorIndex> voters = Voters(config);
  const bool leads = machine.phase == Phase::kStarting || machine.phase == Phase::kRunning ||
                     machine.phase == Phase::kFailed;
  if (!config.failover || !leads) return "";
  const auto is_away = [&](ActuatorIndex i) {
    const KnownActuator& known = machine.actuators[i];
    return known.presence == Presence::kLost && known.health == Health::kPartitioned;
  };
  const auto away = static_cast<std::size_t>(std::ranges::count_if(voters, is_away));
  const std::size_t reached = voters.size() - away;
  if (IsMajority(reached, voters.size())) {
    const auto is_present = [&](ActuatorIndex i) {
      return machine.actuators[i].presence == Presence::kPresent;
    };
    const auto present = static_cast<std::size_t>(std::ranges::count_if(voters, is_present));
    reached_ |= IsMajority(present, voters.size());
    lost_since_.reset();
    return "";
  }
  if (!reached_) return "";
  if (!lost_since_) lost_since_ = now;
  if (now - *lost_since_ < *config.failover / 2) return "";
  return "it reaches only " + Of(reached, voters.size()) + ", and its standby may lead the others";
}

}  // namespace musher
