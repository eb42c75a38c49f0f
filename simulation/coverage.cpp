#include "musher/simulation/coverage.hpp"

#include <algorithm>
#include <numeric>

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

std::string Padded(std::string text, std::size_t width, bool left) {
  if (text.size() >= width) return text;
  const std::string blank(width - text.size(), ' ');
  return left ? text + blank : blank + text;
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

void Coverage::Add(const Coverage& other) {
  for (std::size_t kind = 0; kind < kIncidentKinds; ++kind) {
    for (std::size_t moment = 0; moment < kMoments; ++moment) {
      counts_[kind][moment] += other.counts_[kind][moment];
    }
  }
}

std::uint64_t Coverage::Of(IncidentKind kind) const {
  const auto& row = counts_[static_cast<std::size_t>(kind)];
  return std::accumulate(row.begin(), row.end(), std::uint64_t{0});
}

std::string Coverage::Text() const {
  constexpr std::size_t kFirst = 18;
  std::string text = Padded("", kFirst, true);
  for (const std::string_view name : kNames) text += " " + std::string(name);
  text += "\n";
  for (std::size_t kind = 0; kind < kIncidentKinds; ++kind) {
    text += Padded(std::string(KindName(static_cast<IncidentKind>(kind))), kFirst, true);
    for (std::size_t moment = 0; moment < kMoments; ++moment) {
      const std::uint64_t count = counts_[kind][moment];
      text += " " + Padded(count == 0 ? "-" : std::to_string(count), kNames[moment].size(), false);
    }
    text += "\n";
  }
  return text;
}

}  // namespace musher::simulation
