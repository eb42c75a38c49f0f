#include "musher/simulation/moment.hpp"

#include <algorithm>
#include <array>

namespace musher::simulation {
namespace {

constexpr std::array<std::string_view, kMoments> kNames = {
    "nobody leads", "setting up",   "at rest",      "joining", "sent",         "half way",
    "asking",       "rolling back", "falling back", "stopped", "tearing down", "over"};

Moment MomentOfSwitch(const Switch& s, const Machine& machine) {
  if (s.rolling_back) return Moment::kRollingBack;
  if (s.purpose == Purpose::kStop) return Moment::kTearingDown;
  const bool asking =
      std::any_of(machine.actuators.begin(), machine.actuators.end(),
                  [](const ActuatorRecord& r) { return r.order && r.order->asked > 0; });
  if (asking) return Moment::kAsking;
  if (s.purpose == Purpose::kFallback) return Moment::kFallingBack;
  const bool some = std::any_of(s.legs.begin(), s.legs.end(), [](const Leg& leg) {
    return leg.progress == Leg::Progress::kEnded;
  });
  return some ? Moment::kHalfWay : Moment::kSent;
}

}  // namespace

std::string_view MomentName(Moment moment) {
  return kNames[static_cast<std::size_t>(moment)];
}

Moment MomentOf(const Machine* machine) {
  if (machine == nullptr) return Moment::kNoController;
  if (machine->current) return MomentOfSwitch(*machine->current, *machine);
  switch (machine->phase) {
    case Phase::kStopping:
      return Moment::kTearingDown;
    case Phase::kStopped:
    case Phase::kFailed:
      return Moment::kOver;
    case Phase::kStarting:
      return Moment::kSettingUp;
    default:
      break;
  }
  const bool joining = std::any_of(machine->actuators.begin(), machine->actuators.end(),
                                   [](const ActuatorRecord& r) { return r.order.has_value(); });
  if (joining) return Moment::kJoining;
  return machine->emergency_stop ? Moment::kStopped : Moment::kAtRest;
}

}  // namespace musher::simulation
