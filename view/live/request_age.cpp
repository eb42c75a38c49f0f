#include "musher/view/live/request_age.hpp"

#include <algorithm>
#include <optional>

#include "musher/base/code.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::view {

Result<> CheckAge(std::int64_t seen_ms, std::int64_t now_ms) {
  const std::string rest = ". Nothing was done; look at the robot and press again";
  if (seen_ms < 0 || seen_ms > now_ms) {
    return Error{kCodeStateInvalid,
                 "the request is late: it was made before this host was booted" + rest};
  }
  const std::int64_t age_ms = now_ms - seen_ms;
  if (age_ms <= kMostAgeMs) return Ok();
  return Error{kCodeStateInvalid, "the request is late: what its page shows is " +
                                      std::to_string(age_ms / 1000) + " s old" + rest};
}

bool OnlyLowers(const msg::MachineStatus& status, const std::string& target,
                const std::string& actuator) {
  if (target == kTearDown || target == kError) return true;
  const std::optional<Rank> to = BuiltInRank(target);
  if (!to) return false;
  const auto is_below = [to](const std::string& state) {
    const std::optional<Rank> from = BuiltInRank(state);
    return from && *to < *from;
  };
  const auto raises_nothing = [to](const std::string& from) {
    return IsBuiltInState(from) && RaisesNothing(BuiltInRank(from), *to);
  };
  // An actuator that is degraded in the target, or that an emergency stop holds there, runs its
  // callback once more.
  const auto rests = [&](const msg::ActuatorInfo& one) {
    const bool held = std::ranges::count(status.held_by_stop, one.name) != 0;
    return one.state == target && one.target.empty() && !one.degraded && !held;
  };
  // A busy one is switched from where its callback leads.
  const auto is_not_raised = [&](const msg::ActuatorInfo& one) {
    if (one.presence != "present" || rests(one)) return true;
    const bool waits_safely =
        one.target.empty() || one.target == target || raises_nothing(one.target);
    return waits_safely && raises_nothing(one.state);
  };
  if (!actuator.empty()) {
    const auto named = std::ranges::find(status.actuators, actuator, &msg::ActuatorInfo::name);
    return named != status.actuators.end() && is_below(named->state) && is_not_raised(*named);
  }
  // One of them may rest lower than the machine: it would be raised.
  return is_below(status.state) && std::ranges::all_of(status.actuators, is_not_raised);
}

}  // namespace musher::view
