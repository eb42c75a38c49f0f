#include "musher/lifecycle/actuator/actuator_core.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

using namespace actuator_action;  // NOLINT(google-build-using-namespace)
namespace event = actuator_event;

// The number of announced controllers that are kept: those received last.
constexpr std::size_t kAnnouncedKept = 8;
// The number of released emergency stops that are kept; older ones have no samples left.
constexpr std::size_t kReleasedKept = 256;
// The number of engaged stops that are kept, the newest; one more stops the actuator like the
// others. The controller knows more: its release ends them all.
constexpr std::size_t kMostStops = 64;
constexpr std::size_t kLongestStopWords = 2048;  // bytes; a status carries no more of a stop

// `by` of a stop that is engaged because no permit arrived: the key of the config.
constexpr const char* kPermitKey = "[safety] permit_ms";
// An actuator discovers within this time who gives the permits.
constexpr Duration kFirstPermit = std::chrono::seconds(1);
// Two clocks may diverge by 1/1000 of the time. Crystals do by 1/10000 at most.
constexpr std::int64_t kFastestDrift = 1000;
// The number of senders of permits that are kept: those received last.
constexpr std::size_t kPermitSendersKept = 64;

// No process of a robot runs for longer.
constexpr Duration kLongestRun = std::chrono::hours(24 * 365 * 10);

// The state of an actuator that has lost its controller: `on_controller_lost` of the config. None:
// it stays where it is, as it is at or below that state.
std::optional<State> SafeState(const MachineConfig& config, ActuatorIndex index,
                               const ActuatorCore& core) {
  const State& safe = config.actuators[index].on_controller_lost;
  const auto own = config.RankOf(core.report.state);
  const auto rank = config.RankOf(safe);
  if (!own || !rank || *rank >= *own) return std::nullopt;
  return safe;
}

bool IsAboveDeActive(const MachineConfig& config, const State& state) {
  return SwitchesOnAgain(config, state, state);
}

// Until when the actuator moves on the last permit, or a command waits for the first one; nullopt
// where it needs none, or is stopped.
std::optional<Time> PermitDeadline(const MachineConfig& config, const ActuatorCore& core) {
  if (!config.permit || !core.stops.empty()) return std::nullopt;
  const ActuatorReport& report = core.report;
  if (IsAboveDeActive(config, report.state) || IsAboveDeActive(config, report.target)) {
    return core.permit.until;
  }
  const bool waits = core.waiting && !report.busy();
  return waits ? std::optional(core.permit.first_by) : std::nullopt;
}

std::optional<Time> ControllerDeadline(const MachineConfig& config, ActuatorIndex index,
                                       const ActuatorCore& core) {
  const auto timeout = config.actuators[index].controller_lost;
  if (!timeout || core.controller == 0 || core.report.busy()) return std::nullopt;
  if (!SafeState(config, index, core)) return std::nullopt;
  return core.controller_last_heartbeat + *timeout;
}

// Whether the callback of `target` may switch on. That of the present state does if it undoes a
// failed downward callback, or would switch on what a stop has switched off. It leads down if it
// undoes a failed upward callback.
bool LeadsUp(const MachineConfig& config, const ActuatorCore& core, const State& target) {
  const ActuatorReport& report = core.report;
  if (target != report.state) return MaySwitchOn(config, report.state, target);
  const bool switches_on =
      report.held_by_stop && !core.unsettled && Rises(config, kUninitialized, target);
  return core.half_way_down || switches_on;
}

// One event's decision: the arguments of Step() and the actions so far.
class Decision {
 public:
  Decision(const MachineConfig& config, ActuatorIndex index, ActuatorCore& core, Time now)
      : machine_(config),
        config_(config.actuators[index]),
        index_(index),
        core_(core),
        report_(core.report),
        now_(now) {}

  void On(const event::Started&) {
    if (machine_.permit) core_.permit.first_by = now_ + std::max(*machine_.permit, kFirstPermit);
    Run(State(kSetUp));
  }

  void On(const event::SwitchArrived& arrived) {
    const SwitchCommand& command = arrived.command;
    if (auto refusal = Authority(arrived.sender, command.epoch))
      return Refuse({arrived.token}, *refusal);
    if (Repeated(arrived)) return;
    const auto refusal = CheckCommand(command);
    // The number of a refused command is used up, too: a copy must not run once the stop is
    // released. Not if the command is too old: then its copy is as well. If it only appeared too
    // old, it is sent again with the right clock.
    const bool too_old = refusal && refusal->code == kCodeTimeout;
    if (command.incarnation == report_.incarnation && !too_old) UseUp(command.number);
    if (refusal) return Refuse({arrived.token}, *refusal);
    DropWaiting(Refused<Refusal::kCommandReplaced>(command.number));
    if (report_.busy() || AwaitsPermit(command.target)) {
      core_.waiting = {command, {arrived.token}, !core_.stops.empty()};
      return Do(PublishStatus{});
    }
    Begin(command, {arrived.token});
  }

  void On(const event::QueryArrived& arrived) {
    if (auto refusal = Authority(arrived.sender, arrived.command.epoch))
      return Refuse({arrived.token}, *refusal);
    const CommandNumber number = arrived.command.number;
    UseUp(number);
    if (core_.waiting && core_.waiting->command.number <= number) {
      DropWaiting(Refused<Refusal::kCommandCancelled>());
    }
    if (arrived.command.stop && report_.busy()) Do(RequestStop{});
    Do(Answer{arrived.token, Verdict::kDone, kCodeOk, ""});
    Do(PublishStatus{});
  }

  void On(const event::ManagerCommand& arrived) {
    if (auto refusal = EvaluateManager(arrived.target)) return Refuse({arrived.token}, *refusal);
    SwitchCommand command;  // with number 0, which no controller uses
    command.target = arrived.target;
    Begin(command, {arrived.token});
  }

  void On(const event::CallbackEnded& ended) {
    const State target = std::exchange(report_.target, "");
    const auto tokens = std::exchange(core_.running_for, {});
    const event::CallbackEnded end = UnderStop(target, ended);
    if (target == kSetUp) return EndSetUp(end);
    const bool down = Falls(machine_, report_.state, target);
    EndCommand(std::exchange(report_.busy_number, CommandNumber()), target, end.code, end.message);
    if (target == kSelfCheck) {
      const bool passed = end.code == kCodeOk;
      report_.degraded_code = passed ? end.degraded_code : kCodeOk;
      report_.degraded_reason = passed ? end.degraded_reason : "";
    } else if (end.code == kCodeOk && !core_.under_stop && !down) {
      report_.held_by_stop = false;
    }
    if (target != kSelfCheck && end.code != kCodeOk) report_.detached = core_.was_detached;
    AnswerAll(tokens, end.code == kCodeOk ? Verdict::kDone : Verdict::kFailed,
              {end.code, end.message});
    if (target == kTearDown && end.code == kCodeOk) return EndTornDown();
    if (!BeginWaiting()) Do(PublishStatus{});
  }

  // The next self-check replaces it.
  void On(const event::PartFailed& failed) {
    const bool over = failed.code == kCodeOk;
    if (over ? report_.degraded_reason != failed.reason
             : report_.degraded_code == failed.code && report_.degraded_reason == failed.reason) {
      return;
    }
    report_.degraded_code = failed.code;
    report_.degraded_reason = over ? "" : failed.reason;
    Do(PublishStatus{});
  }

  void On(const event::ControllerHeartbeatReceived& received) {
    if (received.sender == 0) return;
    if (received.sender == core_.controller) core_.controller_last_heartbeat = now_;
    auto& announced = core_.announced;
    std::erase_if(announced, [&](const auto& one) { return one.sender == received.sender; });
    announced.push_back(received);
    if (announced.size() > kAnnouncedKept) announced.erase(announced.begin());
  }

  void On(const event::EmergencyStopReceived& received) {
    const bool entitled = received.sender == core_.controller && core_.controller != 0;
    if (received.engaged) {
      // The controller decides.
      if (entitled && !IsReleasedBy(received.sender, received.id)) ForgetRelease(received.id);
      const StopId unnamed(received.sender.value());
      const StopId id = received.id != 0 ? received.id : unnamed != 0 ? unnamed : kUnknownStop;
      return Engage({id, received.by, received.reason});
    }
    if (!entitled) return;
    core_.last_before_release = std::max(core_.last_before_release, received.last_command);
    EndFromBefore(received.last_command);
    ForgetRelease(received.id);
    core_.released.push_back({received.id, received.sender});
    if (core_.released.size() > kReleasedKept) core_.released.erase(core_.released.begin());
    const auto same = [&](const EmergencyStop& stop) { return stop.id == received.id; };
    const bool ended = std::erase_if(core_.stops, same) != 0;
    const bool confirmed = std::exchange(report_.released_stop, received.id) == received.id;
    if (ended || !confirmed) ReportStops();
  }

  void On(const event::PermitReceived& received) {
    if (!machine_.permit || received.sender == 0) return;
    if (received.stamp <= Time() || received.stamp > Time() + kLongestRun) return;
    Permit& permit = core_.permit;
    const Time until = now_ - LatenessOf(received) + *machine_.permit;
    // Permits may arrive together, as after the process was frozen. Then the last one counts.
    const bool newer = until == permit.until && received.stamp > permit.stamp;
    if (until <= permit.until && !newer) return;
    permit.until = until;
    permit.stamp = received.stamp;
    permit.by = received.by;
    BeginWaiting();
  }

  // Stops when no permit has arrived, and goes to the safe state when the heartbeat of the
  // controller is lost for too long.
  void On(const event::TimePassed&) {
    StopWithoutPermit(report_.state);
    StopWithoutPermit(report_.target);
    BeginWaiting();
    const auto deadline = ControllerDeadline(machine_, index_, core_);
    if (!deadline || *deadline > now_) return;
    core_.controller_last_heartbeat = now_;  // if it fails, it is retried after the same time
    core_.went_by_itself = now_;
    core_.was_detached = report_.detached;
    report_.busy_number = 0;
    Run(*SafeState(machine_, index_, core_));
  }

  std::vector<ActuatorAction> Take() && { return std::move(actions_); }

 private:
  void Do(ActuatorAction action) { actions_.push_back(std::move(action)); }

  void Run(const State& target) {
    report_.target = target;
    core_.under_stop = !core_.stops.empty();
    Do(RunCallback{target});
    Do(PublishStatus{});
  }

  void UseUp(CommandNumber number) { report_.number = std::max(report_.number, number); }

  void AnswerAll(const std::vector<RequestToken>& tokens, Verdict verdict,
                 const Error& why = {kCodeOk, ""}) {
    for (const RequestToken token : tokens) Do(Answer{token, verdict, why.code, why.message});
  }

  void Refuse(const std::vector<RequestToken>& tokens, const Error& refusal) {
    AnswerAll(tokens, Verdict::kRefused, refusal);
  }

  void DropWaiting(const Error& why) {
    if (const auto dropped = std::exchange(core_.waiting, {})) Refuse(dropped->tokens, why);
  }

  // A TearDown that waits for another one is done with it; any other command is refused.
  void EndTornDown() {
    if (core_.waiting && core_.waiting->command.target == kTearDown) {
      const auto waiting = *std::exchange(core_.waiting, std::nullopt);
      Begin(waiting.command, waiting.tokens);
    }
    DropWaiting(Refused<Refusal::kActuatorEnds>());
    Do(PublishStatus{});
    Do(Finish{});
  }

  // One controller has control: the one with the highest epoch, once it has announced itself.
  std::optional<Error> Authority(Sender sender, Epoch epoch) {
    if (sender == 0) return Refused<Refusal::kSenderUnknown>();
    if (epoch > kLastEpoch) return Refused<Refusal::kEpochOutOfRange>(epoch);
    if (epoch < report_.epoch) return Refused<Refusal::kEpochOutdated>(epoch, report_.epoch);
    if (sender != core_.controller) {
      if (epoch == report_.epoch) return Refused<Refusal::kEpochOfAnother>(epoch);
      const event::ControllerHeartbeatReceived announced{sender, epoch};
      if (std::find(core_.announced.begin(), core_.announced.end(), announced) ==
          core_.announced.end()) {
        return Refused<Refusal::kNotAnnounced>(epoch);
      }
      core_.controller = sender;
      core_.last_before_release = 0;  // of the previous one
      // The new controller does not have the waiting command of the previous one.
      DropWaiting(Refused<Refusal::kTakenOver>(epoch));
    }
    report_.epoch = epoch;
    core_.controller_last_heartbeat = now_;
    return std::nullopt;
  }

  // The lateness of a sample is its delay beyond that of the fastest sample of its sender. So a
  // sample that was held back on the way, or is repeated, permits no more than when it was given,
  // whatever other senders do meanwhile.
  Duration LatenessOf(const event::PermitReceived& received) {
    const Duration taken = now_ - received.stamp;
    PermitSender sender{received.sender, taken, now_};
    auto& senders = core_.permit.senders;
    const auto known = std::ranges::find(senders, received.sender, &PermitSender::sender);
    if (known != senders.end()) {
      const Duration drift = (now_ - known->received) / kFastestDrift;
      sender.fastest = std::min(known->fastest + drift, taken);
      senders.erase(known);
    }
    senders.push_back(sender);
    if (senders.size() > kPermitSendersKept) senders.erase(senders.begin());
    return taken - sender.fastest;
  }

  bool IsPermitted() const { return !machine_.permit || now_ < core_.permit.until; }

  // Whether a command to `target` waits for the first permit of this process.
  bool AwaitsPermit(const State& target) const {
    return !IsPermitted() && now_ < core_.permit.first_by && IsAboveDeActive(machine_, target);
  }

  // Engages a stop if the actuator has no permit for `state`, its present state or the state that
  // it is about to enter. While another stop is engaged, only once that one is released: so a stop
  // has one reason.
  void StopWithoutPermit(const State& state) {
    if (IsPermitted() || !core_.stops.empty() || !IsAboveDeActive(machine_, state)) return;
    Permit& permit = core_.permit;
    const bool any = permit.stamp != Time();
    // Actuators whose last permit was the same engage the same stop.
    const auto last = any ? static_cast<std::uint64_t>(permit.stamp.time_since_epoch().count())
                          : report_.incarnation.value();
    StopId stop = 0;
    do {
      stop = StopId(last + ++permit.stops);
    } while (IsOver(stop));
    Engage({stop, kPermitKey,
            any ? "no permit of " + permit.by + " has arrived for " +
                      std::to_string(ToMilliseconds(*machine_.permit)) + " ms"
                : "no permit to move has arrived"});
  }

  bool IsOver(StopId id) const {
    return std::ranges::count(core_.released, id, &ReleasedStop::id) != 0;
  }

  bool IsReleasedBy(Sender sender, StopId id) const {
    return std::ranges::count(core_.released, ReleasedStop{id, sender}) != 0;
  }

  void ForgetRelease(StopId id) {
    std::erase_if(core_.released, [id](const ReleasedStop& one) { return one.id == id; });
  }

  void Engage(EmergencyStop stop) {
    const bool known = std::ranges::count(core_.stops, stop.id, &EmergencyStop::id) != 0;
    if (IsOver(stop.id) || known) return;
    if (core_.stops.size() >= kMostStops) core_.stops.erase(core_.stops.begin());
    if (stop.by.size() + stop.reason.size() > kLongestStopWords) stop = {stop.id, "", ""};
    core_.stops.push_back(std::move(stop));
    report_.held_by_stop = true;
    core_.stopped_meanwhile = core_.under_stop = report_.busy();
    Do(RunEmergencyStop{});
    if (report_.busy() && SwitchesOn(report_.target)) Do(RequestStop{});
    if (core_.waiting) core_.waiting->stopped = true;
    if (core_.waiting && SwitchesOn(core_.waiting->command.target)) DropWaiting(Stopped());
    ReportStops();
  }

  // For a stop that this actuator has missed: the callback of a command from before the release
  // ends as if the stop had been engaged.
  void EndFromBefore(CommandNumber last_command) {
    const bool before =
        report_.busy() && report_.busy_number != 0 && report_.busy_number <= last_command;
    if (!before || !SwitchesOn(report_.target) || core_.stopped_meanwhile) return;
    core_.stopped_meanwhile = core_.under_stop = true;
    report_.held_by_stop = true;
    Do(RunEmergencyStop{});
    Do(RequestStop{});
  }

  // The status names the oldest stop; the stop ends when that one and all others are released.
  void ReportStops() {
    const EmergencyStop first = core_.stops.empty() ? EmergencyStop{} : core_.stops.front();
    report_.emergency_stop = first.id;
    report_.emergency_stop_by = first.by;
    report_.emergency_stop_reason = first.reason;
    report_.other_stops.clear();
    for (const EmergencyStop& stop : core_.stops) {
      if (stop.id != first.id) report_.other_stops.push_back(stop.id);
    }
    Do(PublishStatus{});
  }

  // The result of a callback that has ended. If an emergency stop was engaged while it ran, it may
  // have switched on again what the stop action had switched off: the action runs again. An upward
  // callback has failed, even if the stop was released before its end.
  event::CallbackEnded UnderStop(const State& target, const event::CallbackEnded& ended) {
    if (!std::exchange(core_.stopped_meanwhile, false)) return ended;
    Do(RunEmergencyStop{});
    if (!SwitchesOn(target) || ended.code != kCodeOk) return ended;
    return {kCodeProtectedError,
            "an emergency stop was engaged while " + target + " ran; the state is not taken"};
  }

  static Error Stopped() { return Refused<Refusal::kStopForbidsSwitchingOn>(); }

  Error StoppedMeanwhile() const {
    return core_.stops.empty() ? Refused<Refusal::kCommandBeforeRelease>() : Stopped();
  }

  bool SwitchesOn(const State& target) const { return LeadsUp(machine_, core_, target); }

  // A repeated command gets the same answer again, or the answer of its run.
  bool Repeated(const event::SwitchArrived& arrived) {
    const CommandNumber number = arrived.command.number;
    if (number == 0) return false;
    if (report_.busy() && number == report_.busy_number) {
      core_.running_for.push_back(arrived.token);
    } else if (core_.waiting && number == core_.waiting->command.number) {
      core_.waiting->tokens.push_back(arrived.token);
    } else if (number == report_.outcome_number) {
      const bool done = report_.outcome_code == kCodeOk;
      Do(Answer{arrived.token, done ? Verdict::kDone : Verdict::kFailed, report_.outcome_code,
                report_.outcome_message});
    } else {
      return false;
    }
    return true;
  }

  std::optional<Error> CheckCommand(const SwitchCommand& command) {
    if (command.incarnation != report_.incarnation) {
      return Refused<Refusal::kOtherProcess>();
    }
    if (command.number <= report_.number) {
      return Refused<Refusal::kCommandOutdated>(command.number, report_.number);
    }
    if (auto refusal = CheckTarget(command.target)) return refusal;
    return MayBegin(command);
  }

  std::optional<Error> EvaluateManager(const State& target) {
    if (report_.epoch != 0) return Refused<Refusal::kControlled>(report_.epoch);
    if (report_.busy()) return Refused<Refusal::kBusy>(report_.target);
    if (auto refusal = CheckStop(target)) return refusal;
    if (auto refusal = CheckTarget(target)) return refusal;
    if (AwaitsPermit(target)) return Refused<Refusal::kNoPermitYet>();
    StopWithoutPermit(target);
    return CheckStop(target);
  }

  std::optional<Error> CheckTarget(const State& target) const {
    if (report_.state == kTearDown && target != kTearDown) {
      return Refused<Refusal::kActuatorTornDown>();
    }
    if (target == kSetUp || target == kUninitialized) {
      return Refused<Refusal::kOnlyAtStart>(target);
    }
    if (!config_.Lists(target)) return Refused<Refusal::kStateMissing>(config_.name, target);
    return std::nullopt;
  }

  std::optional<Error> CheckStop(const State& target) const {
    if (report_.emergency_stop != 0 && SwitchesOn(target)) return Stopped();
    return std::nullopt;
  }

  std::optional<Error> MayBegin(const SwitchCommand& command) {
    if (auto refusal = CheckStop(command.target)) return refusal;
    if (command.number <= core_.last_before_release && SwitchesOn(command.target)) {
      return Refused<Refusal::kCommandBeforeRelease>();
    }
    if (auto refusal = CheckAge(command, now_)) return refusal;
    const Time sent = command.status_stamp + command.since_status;
    if (sent < core_.went_by_itself && SwitchesOn(command.target)) {
      return Refused<Refusal::kCommandBeforeSafeState>(config_.on_controller_lost);
    }
    if (AwaitsPermit(command.target)) return std::nullopt;
    StopWithoutPermit(command.target);
    return CheckStop(command.target);
  }

  // Begins the waiting command if nothing holds it any longer; returns whether it has begun. A stop
  // that was engaged meanwhile refuses a command that leads up from the state of the previous
  // callback, also after the release.
  bool BeginWaiting() {
    const bool waits = core_.waiting && !report_.busy();
    if (!waits || AwaitsPermit(core_.waiting->command.target)) return false;
    const auto next = *std::exchange(core_.waiting, std::nullopt);
    const bool held = next.stopped && SwitchesOn(next.command.target);
    if (auto refusal = held ? StoppedMeanwhile() : MayBegin(next.command)) {
      Refuse(next.tokens, *refusal);
      return false;
    }
    Begin(next.command, next.tokens);
    return true;
  }

  void Begin(const SwitchCommand& command, const std::vector<RequestToken>& tokens) {
    const bool there = command.target == report_.state && command.target != kSelfCheck;
    const bool final = there && command.target == kTearDown;  // also after an emergency stop
    if (final || (there && !core_.unsettled && !report_.held_by_stop)) {
      EndCommand(command.number, command.target, kCodeOk, "");
      report_.detached = command.detached;
      AnswerAll(tokens, Verdict::kDone);
      return Do(PublishStatus{});
    }
    report_.busy_number = command.number;
    core_.running_for = tokens;
    core_.was_detached = report_.detached;
    if (command.target != kSelfCheck) report_.detached = command.detached;
    Run(command.target);
  }

  void EndSetUp(const event::CallbackEnded& ended) {
    report_.outcome_code = ended.code;
    report_.outcome_message = ended.message;
    if (ended.code == kCodeOk) {
      report_.state = State(kSetUp);
      Do(BecomeVisible{});
    }
    Do(PublishStatus{});
    if (ended.code != kCodeOk) Do(Finish{ended.code, ended.message});
  }

  void EndCommand(CommandNumber number, const State& target, std::int32_t code,
                  const std::string& message) {
    if (number != 0) {  // what it did by itself is not the outcome of a command
      report_.outcome_number = number;
      report_.outcome_code = code;
      report_.outcome_message = message;
    }
    if (target == kSelfCheck) {
      // In the run phase a check does not change the state; during start-up it is a step.
      const bool a_step =
          report_.state == kSetUp || report_.state == kSelfCheck || report_.state == kError;
      if (code == kCodeOk && a_step) report_.state = target;
      return;
    }
    core_.unsettled = code != kCodeOk;
    const bool switches_on = target == report_.state && report_.held_by_stop;
    core_.half_way_down = core_.unsettled && (core_.half_way_down || switches_on ||
                                              Rises(machine_, target, report_.state) ||
                                              SwitchesOnAgain(machine_, target, report_.state));
    if (code == kCodeOk) report_.state = target;
  }

  const MachineConfig& machine_;
  const ActuatorConfig& config_;
  const ActuatorIndex index_;
  ActuatorCore& core_;
  ActuatorReport& report_;
  Time now_;
  std::vector<ActuatorAction> actions_;
};

}  // namespace

std::optional<Error> CheckAge(const SwitchCommand& command, Time now) {
  // The times of an unknown sender may be arbitrary: invalid ones are not used.
  const bool possible = command.status_stamp <= now && command.status_stamp >= now - kLongestRun &&
                        command.since_status >= Duration::zero() &&
                        command.since_status <= kLongestRun;
  if (!possible) return Refused<Refusal::kCommandWithoutAge>();
  const Duration age = now - command.status_stamp - command.since_status;
  if (age <= command.budget) return std::nullopt;
  return Refused<Refusal::kCommandTooOld>(ToMilliseconds(age), ToMilliseconds(command.budget));
}

std::vector<ActuatorAction> Step(const MachineConfig& config, ActuatorIndex index,
                                 ActuatorCore& core, const ActuatorEvent& event, Time now) {
  Decision deciding(config, index, core, now);
  std::visit([&](const auto& e) { deciding.On(e); }, event);
  return std::move(deciding).Take();
}

State StillSwitchingOn(const MachineConfig& config, const ActuatorCore& core) {
  const State& target = core.report.target;
  return core.stopped_meanwhile && LeadsUp(config, core, target) ? target : State();
}

std::optional<Time> NextDeadline(const MachineConfig& config, ActuatorIndex index,
                                 const ActuatorCore& core) {
  const auto controller = ControllerDeadline(config, index, core);
  const auto permit = PermitDeadline(config, core);
  if (controller && permit) return std::min(*controller, *permit);
  return controller ? controller : permit;
}

}  // namespace musher
