// The choices in a state of the world.

#include <algorithm>
#include <utility>

#include "musher/search/harness.hpp"

namespace musher::search {
namespace {

bool Expects(const World& world, const SimActuator& actuator) {
  const auto& tokens = actuator.core.running_for;
  return std::any_of(tokens.begin(), tokens.end(), [&](RequestToken token) {
    return (token.value() & 127) == world.generation + 1;
  });
}

// Whether a hang of its work thread is noticed.
bool HasCheckpoint(const ActuatorConfig& actuator, const SimActuator& now) {
  return actuator.checkpoint || actuator.checkpoint_in.contains(now.core.report.target);
}

// With an empty list every failure of a self-check is tolerated: it has no other one.
bool ToleratesSomeCodes(const ActuatorConfig& actuator) {
  return actuator.critical_codes && !actuator.critical_codes->empty();
}

class ChoiceList {
 public:
  ChoiceList(const Model& model, const World& world) : model_(model), world_(world) {}

  std::vector<Choice> Make() && {
    if (!world_.outbox.empty()) {
      ListSending();
      return std::move(choices_);
    }
    ListStop();
    if (world_.at_start) {
      Free(ChoiceKind::kRequest);
      if (world_.stop_seen_due) Free(ChoiceKind::kSeeStop);
      return std::move(choices_);
    }
    for (const ActuatorIndex i : world_.actuators.Indices()) ListActuator(i);
    if (world_.battery_due && Leads()) Free(ChoiceKind::kBattery);
    if (world_.stop_seen_due && Leads()) Free(ChoiceKind::kSeeStop);
    ListTime();
    if (world_.faults_left > 0 && Leads()) {
      ListStarts();
      Fault(ChoiceKind::kRequestError);
      if (world_.machine.phase != Phase::kStopping) {
        Fault(ChoiceKind::kRequestTearDown);
        ListBattery();
      }
    }
    if (model_.other_machine) ListOtherMachine();
    for (std::size_t host = 0; host < world_.links.size(); ++host) ListLink(host);
    ListRelease();
    return std::move(choices_);
  }

 private:
  bool Leads() const { return world_.machine.phase != Phase::kStopped; }

  void Free(ChoiceKind kind, ActuatorIndex i = 0, std::size_t index = 0) {
    choices_.push_back(
        {kind, static_cast<std::uint8_t>(i.value()), static_cast<std::uint8_t>(index), 0});
  }
  void Fault(ChoiceKind kind, ActuatorIndex i = 0, std::size_t index = 0) {
    if (world_.faults_left > 0 && IsSearched(kind))
      choices_.push_back(
          {kind, static_cast<std::uint8_t>(i.value()), static_cast<std::uint8_t>(index), 1});
  }

  bool IsSearched(ChoiceKind fault) const {
    return (model_.faults >> static_cast<int>(fault) & 1) != 0;
  }

  void ListStop() {
    if (world_.stopped || !Leads()) return;
    Fault(ChoiceKind::kEngageStop);
    if (!IsSearched(ChoiceKind::kEngageStopLate)) return;
    for (const ActuatorIndex i : world_.actuators.Indices()) {
      if (world_.faults_left <= 1 || !world_.actuators[i].alive) continue;
      choices_.push_back({ChoiceKind::kEngageStopLate, static_cast<std::uint8_t>(i.value()), 0, 2});
    }
  }

  void ListRelease() {
    const bool is_quiet = IsQuiet(world_, choices_);
    if (!model_.releases || (!is_quiet && !model_.releases_early)) return;
    if (!world_.released && world_.machine.emergency.stop) Free(ChoiceKind::kRelease);
    if (!is_quiet) return;
    const bool runs = world_.machine.phase == Phase::kRunning;
    if (world_.released && world_.repeat == Repeat::kNotYet && runs) Free(ChoiceKind::kRepeat);
  }

  // A person's start differs from a supervisor's after a TearDown. After a stop it would be a
  // request.
  void ListStarts() {
    Fault(ChoiceKind::kRestart);
    if (world_.disk.stop_intent && !world_.stopped) Fault(ChoiceKind::kStartByPerson);
  }

  // Not between two commands of one step, where ListSending() alone counts.
  void ListOtherMachine() {
    for (const ActuatorIndex i : world_.actuators.Indices()) {
      const SimActuator& actuator = world_.actuators[i];
      if (!actuator.alive || !actuator.visible) continue;
      Fault(ChoiceKind::kOtherCommand, i);
      if (actuator.core.report.emergency_stop != 0) Fault(ChoiceKind::kOtherRelease, i);
    }
    if (Leads() && world_.machine.epoch > 0) Fault(ChoiceKind::kOtherHeartbeat);
  }

  void ListBattery() {
    if (!model_.config.policy) return;
    const std::vector<std::int32_t> levels = BatteryLevels(model_.config);
    for (std::size_t k = 0; k < levels.size(); ++k) {
      if (!world_.battery || levels[k] < *world_.battery) Fault(ChoiceKind::kBatteryFalls, 0, k);
    }
  }

  // The search has no release of a stop in machines with another host.
  void ListLink(std::size_t host) {
    if (!Leads() || model_.releases) return;
    const Link& link = world_.links[host];
    ActuatorIndex first = 0;
    while (model_.host_of[first] != host) ++first;
    if (link.cut) return Free(link.silent_by ? ChoiceKind::kSilence : ChoiceKind::kReach, first);
    Fault(ChoiceKind::kCutLink, first);
    Fault(ChoiceKind::kRebootHost, first);
  }

  void ListSending() {
    const Message& first = world_.outbox.front();
    const SimActuator& actuator = world_.actuators[first.to];
    Free(ChoiceKind::kDeliver, first.to);
    ListStop();
    ListStarts();
    if (IsOut(first.to)) return;
    if (model_.host_of[first.to] != kHere) ListLink(model_.host_of[first.to]);
    if (!actuator.alive || !actuator.visible) return;
    Fault(ChoiceKind::kLose, first.to);
    Fault(ChoiceKind::kHold, first.to);
    Fault(ChoiceKind::kDuplicate, first.to);
    if (actuator.core.controller != first.sender) Fault(ChoiceKind::kUnannounced, first.to);
  }

  void ListActuator(ActuatorIndex i) {
    const SimActuator& actuator = world_.actuators[i];
    if (IsOut(i)) return ListOutOfReach(i);
    if (actuator.unit_report != UnitReport::kNone && !actuator.end)
      Free(ChoiceKind::kUnitReport, i);
    if (actuator.silent) Free(ChoiceKind::kHeartbeat, i);
    if (actuator.end) Free(ChoiceKind::kEnd, i);
    for (std::size_t k = 0; k < actuator.late.size(); ++k) Free(ChoiceKind::kLate, i, k);
    if (!actuator.replies.empty()) {
      Free(ChoiceKind::kReply, i);
      for (const ChoiceKind d : {ChoiceKind::kReplyHeld, ChoiceKind::kReplyDuplicated}) Fault(d, i);
      // The last reply of an ended process may be lost with it.
      actuator.alive ? Fault(ChoiceKind::kReplyLost, i) : Free(ChoiceKind::kReplyLost, i);
    }
    if (actuator.status_due) {
      Free(ChoiceKind::kStatus, i);
      Fault(ChoiceKind::kStatusLost, i);
      Fault(ChoiceKind::kStatusHeld, i);
      Fault(ChoiceKind::kStatusDuplicated, i);
    }
    if (!actuator.alive) return;
    Fault(ChoiceKind::kCrash, i);
    if (ListHang(i)) return;
    if (actuator.work == Work::kNone) return;
    Free(ChoiceKind::kEndOk, i);
    if (actuator.core.report.target == kTearDown) Free(ChoiceKind::kEndFirst, i);
    Fault(ChoiceKind::kEndFailed, i);
    const bool has_codes = ToleratesSomeCodes(model_.config.actuators[i]);
    if (has_codes && actuator.core.report.target == kSelfCheck) Fault(ChoiceKind::kEndTolerated, i);
    if (actuator.work == Work::kOverdue && actuator.stop_requested)
      Free(ChoiceKind::kEndOnRequest, i);
    if (!Expects(world_, actuator) || !actuator.replies.empty()) return;
    if (actuator.core.report.target != kTearDown) Fault(ChoiceKind::kEndCrash, i);
    Fault(ChoiceKind::kEndReplyLost, i);
    Fault(ChoiceKind::kEndReplyHeld, i);
    Fault(ChoiceKind::kEndReplyDuplicated, i);
  }

  // Returns whether it hangs.
  bool ListHang(ActuatorIndex i) {
    const SimActuator& actuator = world_.actuators[i];
    const KnownActuator& known = world_.machine.actuators[i];
    const bool is_known = known.report.incarnation == actuator.core.report.incarnation;
    if (actuator.backtrace_due) Free(ChoiceKind::kBacktrace, i);
    if (!actuator.hung) {
      const bool noticed = is_known && HasCheckpoint(model_.config.actuators[i], actuator);
      if (noticed && Leads()) Fault(ChoiceKind::kHang, i);
      return false;
    }
    if (actuator.hang_due && is_known && Leads()) Free(ChoiceKind::kHangReport, i);
    Free(ChoiceKind::kProgress, i);
    return true;
  }

  // Its callback ends, or its process, and nothing of that arrives.
  void ListOutOfReach(ActuatorIndex i) {
    const SimActuator& actuator = world_.actuators[i];
    if (actuator.await_by && Leads()) Free(ChoiceKind::kAwait, i);
    if (!actuator.alive) return;
    Fault(ChoiceKind::kCrash, i);
    if (actuator.work == Work::kNone || actuator.hung) return;
    Free(ChoiceKind::kEndOk, i);
    Fault(ChoiceKind::kEndFailed, i);
    const bool has_codes = ToleratesSomeCodes(model_.config.actuators[i]);
    if (has_codes && actuator.core.report.target == kSelfCheck) Fault(ChoiceKind::kEndTolerated, i);
    if (actuator.work == Work::kOverdue && actuator.stop_requested)
      Free(ChoiceKind::kEndOnRequest, i);
  }

  bool IsOut(ActuatorIndex i) const { return IsOutOfReach(model_, world_, i); }

  // Whether something is under way from the actuator.
  bool IsSending(ActuatorIndex i) const {
    const SimActuator& actuator = world_.actuators[i];
    if (IsOut(i)) return false;
    return actuator.end || actuator.status_due || !actuator.replies.empty() || actuator.silent ||
           actuator.unit_report != UnitReport::kNone || actuator.backtrace_due;
  }

  // Whether a host that is out of reach is noticed before `next`.
  bool IsNoticedBefore(Time next) const {
    return std::ranges::any_of(
               world_.links,
               [&](const Link& link) { return link.silent_by && *link.silent_by < next; }) ||
           std::ranges::any_of(world_.actuators, [&](const SimActuator& one) {
             return one.await_by && *one.await_by < next;
           });
  }

  bool StandsStill() const {
    if ((world_.stop_seen_due || world_.battery_due) && Leads()) return true;
    const auto indices = world_.actuators.Indices();
    return std::any_of(indices.begin(), indices.end(),
                       [&](ActuatorIndex i) { return IsSending(i); });
  }

  // Time passes when no message is under way; a callback that still runs then is overdue.
  void ListTime() {
    if (StandsStill()) return;
    const auto next = NextDeadline(model_.config, world_.machine);
    if (next && !IsNoticedBefore(*next)) {
      std::uint8_t running = 0;
      std::uint8_t overdue = 0;
      for (const ActuatorIndex i : world_.actuators.Indices()) {
        if (world_.actuators[i].work != Work::kRunning) continue;
        ++running;
        const auto own = OverdueAt(world_, i);
        if (own && *own <= *next) ++overdue;
      }
      PassTime(0, running);
      if (!model_.timed_rules.empty() && overdue < running) PassTime(1, overdue);
    }
    if (!model_.timed_rules.empty() && EndOfWait(model_, world_)) Free(ChoiceKind::kWait);
  }

  void PassTime(std::uint8_t index, std::uint8_t cost) {
    if (cost > 0 && (cost > world_.faults_left || !IsSearched(ChoiceKind::kTime))) return;
    choices_.push_back({ChoiceKind::kTime, 0, index, cost});
  }

  const Model& model_;
  const World& world_;
  std::vector<Choice> choices_;
};

}  // namespace

std::vector<std::int32_t> BatteryLevels(const MachineConfig& config) {
  if (!config.policy || !config.policy->battery) return {};
  const BatteryPolicy& battery = *config.policy->battery;
  return {battery.protected_at, battery.low_power_at, battery.tear_down_at};
}

std::optional<Time> OverdueAt(const World& world, ActuatorIndex i) {
  const KnownActuator& known = world.machine.actuators[i];
  if (known.command) return known.command->deadline;
  if (known.set_up_by && known.presence != Presence::kPresent) return known.set_up_by;
  return known.free_by;
}

std::optional<Time> EndOfWait(const Model& model, const World& world) {
  std::optional<Time> end = NextDeadline(model.config, world.machine);
  const auto consider = [&end](const std::optional<Time>& when) {
    if (when) end = end ? std::min(*end, *when) : *when;
  };
  for (const Link& link : world.links) consider(link.silent_by);
  for (const SimActuator& one : world.actuators) consider(one.await_by);
  if (end) {
    *end -= Duration(1);
  } else if (std::ranges::count(world.actuators, Work::kRunning, &SimActuator::work) > 0) {
    for (const TimedRuleCheck& check : world.timed_checks) {
      if (const auto due = check.due()) end = end ? std::max(*end, *due) : *due;
    }
  }
  return end && *end > world.now ? end : std::nullopt;
}

std::vector<Choice> Choices(const Model& model, const World& world) {
  return ChoiceList(model, world).Make();
}

bool IsQuiet(const World& world, const std::vector<Choice>& choices) {
  return std::all_of(choices.begin(), choices.end(), [&](const Choice& choice) {
    const bool overdue =
        world.actuators[choice.which()].work == Work::kOverdue &&
        (choice.kind == ChoiceKind::kEndOk || choice.kind == ChoiceKind::kEndOnRequest);
    const auto& late = world.actuators[choice.which()].late;
    // A latched status is repeated until it has arrived.
    const bool lost = choice.kind == ChoiceKind::kLate &&
                      (std::holds_alternative<Message>(late[choice.index]) ||
                       std::holds_alternative<event::Replied>(late[choice.index]));
    const bool by_hand = choice.kind == ChoiceKind::kRelease || choice.kind == ChoiceKind::kRepeat;
    const bool never = choice.kind == ChoiceKind::kReach || choice.kind == ChoiceKind::kProgress;
    return choice.cost > 0 || lost || overdue || by_hand || never;
  });
}

}  // namespace musher::search
