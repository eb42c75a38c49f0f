#include "musher/lifecycle/switch/tear_down.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

// The longest wait of TearDown for the disk; also at most a tenth of the budget.
constexpr Duration kIntentTime = Milliseconds(500);

}  // namespace

void TearDown::Begin(const Plan& plan, std::vector<RequestId> requests, RecordId cause,
                     AfterTearDown after, const Requester& by) {
  if (machine_.current) switches_.Supersede(machine_.number + 1, plan.target, cause);
  for (const RequestId request : std::exchange(machine_.start_up.requests, {})) {
    Do(action::AnswerCall{request, Refused<Refusal::kBeingTornDown>()});
  }
  const Duration budget = config_.shutdown_budget;
  Shutdown stopping;
  stopping.begun = now_;
  stopping.tear_down_by = now_ + budget * 7 / 10;
  stopping.kill_at = now_ + budget * 9 / 10;
  stopping.give_up_at = now_ + budget;
  stopping.requests = std::move(requests);
  machine_.stopping = std::move(stopping);
  machine_.phase = Phase::kStopping;
  machine_.fallback.target.reset();
  // A charged battery must not raise an actuator that fails in TearDown and still runs under the
  // next controller.
  memory_.Lower(std::nullopt);
  machine_.stopping->after = after;
  machine_.stopping->cause = cause;
  machine_.stopping->by = by;
  if (after != AfterTearDown::kStartsAgain &&
      !machine_.start_up.finishing) {  // then it is on disk already
    machine_.stopping->intent_by = now_ + std::min(kIntentTime, budget / 10);
    saver_.Save(Stored::kStopIntent);
  }
  const auto silent = FirstSilent();
  if (silent) {
    const Duration wait = std::min(kLongestDiscovery, budget * 3 / 10);
    machine_.stopping->announced_by = now_ + wait;
    RecordSwitch(std::nullopt, 0, kCodeOk,
                 texts::SwitchWaiting(
                     Describe(config_, plan.target, std::nullopt), wait,
                     ConfigOf(*silent).name + (IsDisconnected(*silent)
                                                   ? " runs, and its connection was lost"
                                                   : " may run, and has not announced itself yet")),
                 cause);
    switches_.EndWaiting(Refused<Refusal::kBeingTornDown>(), cause);
  }
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    known.set_up_by.reset();
    known.restart.at.reset();
    known.restart.requested = false;
    auto& termination = known.process.termination;
    if (termination && termination->for_silence) termination.reset();
    if (!MayAnnounceItself(i)) EndWithout(i);
  }
  if (!silent) BeginSwitch(plan);
}

// Before the switch, for an actuator that is not awaited. If the actuator is not present, its
// process is ended by a signal.
void TearDown::EndWithout(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  known.control.again.reset();
  const bool present = known.presence == Presence::kPresent;
  // What an exited process leaves behind is listed later; one without TearDown has nothing to fail
  // in.
  const bool has_part = present && known.state() != kTearDown && ConfigOf(i).Lists(kTearDown);
  if (!has_part) known.fault.reset();
  if (present) return;
  const std::int32_t pid = OwnProcess(i);
  if (pid != 0 && !RunsAnother(i, pid)) Do(action::SignalProcess{i, pid, false});
}

// Whether an actuator that has a TearDown before it runs in the process, too.
bool TearDown::RunsAnother(ActuatorIndex i, std::int32_t pid) const {
  const auto all = machine_.actuators.Indices();
  return std::any_of(all.begin(), all.end(), [&](ActuatorIndex other) {
    const KnownActuator& known = Of(other);
    return other != i && known.presence == Presence::kPresent && known.state() != kTearDown &&
           ConfigOf(other).Lists(kTearDown) && known.report.pid == pid &&
           known.report.host == HostOf(i);
  });
}

void TearDown::BeginSwitch(const Plan& plan) {
  machine_.stopping->announced_by.reset();
  ListSurvivors();
  switches_.Begin(plan, Purpose::kStop, {}, machine_.stopping->cause, machine_.stopping->by);
}

// Whether only its connection was lost, and its process runs: as of each actuator after a pause of
// this controller that was longer than the lease of its participant.
bool TearDown::IsDisconnected(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  const bool by_itself = known.fault && known.fault->event == EventName::kConnectionLost;
  const bool is_queried = known.presence == Presence::kStarting && known.control.again;
  return (known.presence == Presence::kLost || is_queried) && by_itself && OwnProcess(i) != 0 &&
         known.health != Health::kHung && !known.process.termination;
}

// Whether the actuator may run without being known to this controller yet: its name is held on this
// host, an earlier controller has left it on another host, or a person starts it. A Musher process
// of this host holds its name.
bool TearDown::MayAnnounceItself(ActuatorIndex i) const {
  if (IsDisconnected(i)) return true;
  const KnownActuator& known = Of(i);
  const bool silent = known.presence == Presence::kAbsent || known.presence == Presence::kStarting;
  // The start that finishes a TearDown has awaited all of them, unless this is requested in it.
  const bool awaited = machine_.start_up.finishing && machine_.start_up.set_up;
  if (!silent || known.fault || awaited) return false;
  const bool elsewhere = known.elsewhere && known.report.incarnation == 0;
  const bool holds_name =
      ConfigOf(i).protocol == Protocol::kMusher && config_.transport != TransportProfile::kLan;
  return known.process.launch == Launch::kFoundRunning || elsewhere ||
         (ConfigOf(i).command.empty() && !holds_name);
}

std::optional<ActuatorIndex> TearDown::FirstSilent() const {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (MayAnnounceItself(i)) return i;
  }
  return std::nullopt;
}

// Begins the switch once all have announced themselves, or their time is over. Returns whether it
// has.
bool TearDown::BeginWaiting() {
  if (!machine_.stopping->announced_by) return false;
  if (now_ < *machine_.stopping->announced_by && FirstSilent()) return false;
  const Plan plan = MakePlan(config_, machine_, State(kTearDown));
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (MayAnnounceItself(i)) EndWithout(i);
  }
  BeginSwitch(plan);
  return true;
}

// If several requests for TearDown join, the one that keeps the machine down counts.
void TearDown::Join(const event::SetStateRequested& requested) {
  Shutdown& stopping = *machine_.stopping;
  stopping.requests.push_back(requested.request);
  if (requested.after >= stopping.after) return;
  const bool saved = stopping.after != AfterTearDown::kStartsAgain || machine_.start_up.finishing;
  stopping.after = requested.after;
  if (!saved) saver_.Save(Stored::kStopIntent);
}

bool TearDown::WaitsForIntent() {
  if (!machine_.stopping || !machine_.stopping->intent_by) return false;
  if (now_ < *machine_.stopping->intent_by) return true;
  machine_.stopping->intent_by.reset();
  RecordMachine(kCodeTimeout, texts::StopIntentLate());
  return false;
}

void TearDown::OnTornDown(SwitchResult result) {
  Shutdown& stopping = *machine_.stopping;
  stopping.result = std::move(result);
  const Duration grace = std::min(kExitGrace, config_.shutdown_budget / 10);
  stopping.terminate_at = std::min(now_ + grace, stopping.kill_at);
}

void TearDown::Advance() {
  Shutdown& stopping = *machine_.stopping;
  using Signal = Shutdown::Signal;
  if (stopping.terminate_at && now_ >= *stopping.terminate_at && stopping.sent == Signal::kNone) {
    stopping.sent = Signal::kTerminate;
    SignalProcesses(false);
  }
  if (now_ >= stopping.kill_at && stopping.sent != Signal::kKill) {
    stopping.sent = Signal::kKill;
    SignalProcesses(true);
  }
  power_.Force();
  const bool out_of_time = now_ >= stopping.give_up_at;
  if (out_of_time && machine_.current) EndUnfinished();
  if (!stopping.result) return;
  if (!out_of_time && (ProcessesLeft() || !HasSearched())) return;
  if (stopping.look == Shutdown::Look::kUnderWay) NameSilentHosts();
  SwitchResult result = Conclude(kCodeTimeout, std::nullopt);
  machine_.phase = Phase::kStopped;
  if (stopping.after == AfterTearDown::kMayStart)
    saver_.Save(Stored::kStopIntent);  // there is none now
  RecordMachine(result.code,
                texts::MachineStopped(now_ - stopping.begun,
                                      result.done() ? std::nullopt : std::optional(result.reason)));
  NameUnsavedIntent(result);
  switches_.Answer(stopping.requests, result);
  if (machine_.policy.power) power_.Command(true);
  Do(action::Stopped{});
}

// The machine is down all the same.
void TearDown::NameUnsavedIntent(SwitchResult& result) const {
  if (machine_.stopping->after != AfterTearDown::kStaysDown) return;
  const auto& unsaved = machine_.saves.unsaved;
  const auto intent = std::ranges::find(unsaved, Stored::kStopIntent, &Unsaved::what);
  if (intent == unsaved.end()) return;
  result.reason += (result.reason.empty() ? "" : "; ") + std::string("not on disk: ") +
                   std::string(StoredName(Stored::kStopIntent)) +
                   (intent->why.empty() ? "" : " (" + intent->why + ")") +
                   "; a supervisor that starts the controller again brings the machine up";
}

// The budget is used up while an actuator has not answered TearDown.
void TearDown::EndUnfinished() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (Of(i).command)
      commands_.End(i, {ActuatorOutcome::kLost, kCodeTimeout, texts::NoAnswerWithinBudget(), true});
  }
  for (Leg& leg : machine_.current->legs) {
    if (leg.progress != Leg::Progress::kWaiting) continue;
    EndLeg(leg, {ActuatorOutcome::kSkipped, kCodeTimeout, texts::BudgetUsedUp(), false}, now_);
  }
  OnTornDown(switches_.End().result);
}

// The result of TearDown after the processes have had their time. An actuator that was lost only
// since then, and a process that outlives SIGKILL, are left behind. So is a process that this
// controller was still ending, or starting, when another one, `successor`, took over.
SwitchResult TearDown::Conclude(std::int32_t code, const std::optional<std::string>& successor) {
  ListSurvivors();
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const std::int32_t pid = OwnProcess(i);
    if (pid == 0 && Of(i).process.launch != Launch::kUnderWay) continue;
    if (IsOutOfReach(i)) continue;
    Degrade(i, code, texts::ProcessLeftBehind(pid, successor, ConfigOf(i).host), Of(i).cause);
  }
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (const auto why = WhyMayBeOn(i)) Degrade(i, kCodeStatusError, *why, Of(i).cause);
  }
  SwitchResult result = *machine_.stopping->result;
  result.degraded = Degraded(config_, machine_);
  const bool is_begun =
      result.outcome == SwitchOutcome::kDone || result.outcome == SwitchOutcome::kDoneDegraded;
  if (!is_begun) return result;
  // An actuator left behind degrades "done"; one on a host out of reach replaces an earlier reason,
  // too.
  std::optional<ActuatorIndex> left;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const bool counts = result.outcome == SwitchOutcome::kDone && LeftBehind(i);
    if (!left && (counts || IsOutOfReach(i))) left = i;
  }
  if (!left) return WithUnlisted(std::move(result));
  const Error why = *LeftBehind(*left);
  result.outcome = SwitchOutcome::kDoneDegraded;
  result.code = why.code;
  result.reason = ConfigOf(*left).name + ": " + why.message;
  return result;
}

// An actuator that the config does not list any more has ended in use, too.
SwitchResult TearDown::WithUnlisted(SwitchResult result) const {
  for (const StoredActuator& one : machine_.saves.actuators) {
    if (config_.IndexOf(one.name) || one.lost_in.empty()) continue;
    if (result.outcome != SwitchOutcome::kDone) break;
    result.outcome = SwitchOutcome::kDoneDegraded;
    result.code = kCodeStatusError;
    result.reason = one.name + ", which the config does not list: " +
                    texts::LostWithoutTearDown(one.lost_in).message;
  }
  return result;
}

// Why the actuator may not be torn down; none: it is.
std::optional<Error> TearDown::LeftBehind(ActuatorIndex i) const {
  if (const auto& fault = Of(i).fault) return *fault;
  return SecondProcessOf(Of(i));
}

// Whether the host that runs its command could not be asked.
bool TearDown::IsOutOfReach(ActuatorIndex i) const {
  const auto& fault = Of(i).fault;
  return !ConfigOf(i).host.empty() && fault && fault->event == EventName::kMayStillRun;
}

void TearDown::ListSurvivors() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (const auto why = IsOutOfReach(i) ? std::nullopt : WhyMayRun(i)) {
      Degrade(i, kCodeNetError, *why, Of(i).cause);
    }
    const KnownActuator& known = Of(i);
    const bool unreachable = ConfigOf(i).command.empty() && !ConfigOf(i).Lists(kTearDown);
    if (!unreachable || known.presence != Presence::kPresent) continue;
    Degrade(i, kCodeUnSupport, texts::KeepsRunning(known.state()), known.cause);
  }
}

// Why an actuator that TearDown does not reach may still run; none: it has exited, or is reached,
// or its process is ended with the machine.
std::optional<RecordText> TearDown::WhyMayRun(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  if (IsTaken(i)) {
    return texts::LeftToOther(known.process.pid, ConfigOf(i).host, known.process.taken->how);
  }
  const bool ends_with_it = OwnProcess(i) != 0 && machine_.phase == Phase::kStopping;
  // Found by its name when this controller started, and no status has arrived from it yet.
  const bool found = known.process.launch == Launch::kFoundRunning &&
                     known.presence == Presence::kAbsent && known.process.pid != 0;
  if (found && !ends_with_it) return texts::MayStillRun(std::nullopt);
  if (known.report.incarnation == 0 && known.elsewhere) {
    return texts::MayStillRunOn(known.elsewhere->substr(0, 64));
  }
  const bool reported =
      known.report.incarnation != 0 && known.report.incarnation != known.process.dead;
  const bool out_of_reach =
      known.presence == Presence::kLost || known.presence == Presence::kStarting;
  if (!reported || !out_of_reach || ends_with_it || known.state() == kTearDown) {
    return std::nullopt;
  }
  return texts::MayStillRun(known.state());
}

// Why something that the actuator has switched on may still be on: its process has exited in use
// without its TearDown, and no other process has reached a state of the machine since.
std::optional<RecordText> TearDown::WhyMayBeOn(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  const bool away = known.presence != Presence::kPresent && !known.lost_in.empty();
  if (!away || known.fault || !ConfigOf(i).Lists(kTearDown)) return std::nullopt;
  return texts::LostWithoutTearDown(known.lost_in);
}

bool TearDown::ProcessesLeft() const {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (OwnProcess(i) != 0 || Of(i).process.launch == Launch::kUnderWay) return true;
  }
  return false;
}

// Another controller may have started a process just before it received the heartbeat of this one,
// and the process may not have published anything yet. So processes are searched for once more when
// all known ones have exited.
bool TearDown::HasSearched() {
  const bool may_run =
      std::any_of(config_.actuators.begin(), config_.actuators.end(),
                  [](const ActuatorConfig& actuator) { return !actuator.command.empty(); });
  if (!may_run || machine_.stopping->look == Shutdown::Look::kDone) return true;
  Search();
  return false;
}

// A search that is under way is awaited: a second one would take as long again.
void TearDown::Search() {
  Shutdown::Look& look = machine_.stopping->look;
  if (look != Shutdown::Look::kUnderWay) Do(action::FindProcesses{});
  look = Shutdown::Look::kUnderWay;
}

// The budget is used up before the other hosts have answered the last search.
void TearDown::NameSilentHosts() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const ActuatorProcess& process = Of(i).process;
    const bool exited =
        process.ended_pid != 0 || (process.dead != 0 && process.dead == Of(i).report.incarnation);
    if (ConfigOf(i).host.empty() || exited || IsOutOfReach(i) || IsTaken(i)) continue;
    const std::string why =
        "the search for its process was not answered within the shutdown budget";
    Degrade(i, kCodeNetError, texts::HostUnreached(ConfigOf(i).host, why), Of(i).cause);
  }
}

void TearDown::On(const event::ProcessesFound& found) {
  if (machine_.phase != Phase::kStopping) return;
  Shutdown& stopping = *machine_.stopping;
  if (stopping.look == Shutdown::Look::kUnderWay) {
    stopping.look = ProcessesLeft() ? Shutdown::Look::kNotYet : Shutdown::Look::kDone;
  }
  for (const ActuatorIndex i : found.unreached.Indices()) {
    const std::string& why = found.unreached[i];
    if (!why.empty()) {
      Degrade(i, kCodeNetError, texts::HostUnreached(ConfigOf(i).host, why), Of(i).cause);
    } else if (!ConfigOf(i).host.empty() && found.processes[i] == 0) {
      ForgetElsewhere(i);
    }
  }
  for (const ActuatorIndex i : found.processes.Indices()) {
    const std::int32_t pid = found.processes[i];
    if (pid == 0 || ConfigOf(i).command.empty() || OwnProcess(i) != 0 || IsTaken(i)) continue;
    Of(i).process.pid = pid;
    if (found.hosts.size() == found.processes.size()) Of(i).process.host = found.hosts[i];
    RecordProcess(i, kCodeOk, texts::ProcessFound(pid, ConfigOf(i).name), Of(i).cause);
    Do(action::SignalProcess{i, pid, stopping.sent == Shutdown::Signal::kKill});
    stopping.look = Shutdown::Look::kNotYet;  // again, once it has ended
  }
}

// The host that an earlier controller has stored runs no process of the actuator any more.
void TearDown::ForgetElsewhere(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  if (known.report.incarnation != 0 || !known.elsewhere) return;
  known.elsewhere.reset();
  if (known.fault && known.fault->event == EventName::kMayStillRun) known.fault.reset();
  saver_.Save(Stored::kRemoteActuators);
}

void TearDown::SignalProcesses(bool kill) {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const std::int32_t pid = OwnProcess(i);
    if (pid == 0) continue;
    RecordProcess(i, kCodeTimeout, texts::ProcessSignalled(ConfigOf(i).name, pid, kill));
    Do(action::SignalProcess{i, pid, kill});
  }
  // Which hosts are out of reach is known before the end.
  const bool several_hosts = std::ranges::any_of(
      config_.actuators, [](const ActuatorConfig& actuator) { return !actuator.host.empty(); });
  // SIGKILL is the first signal if the switch has not ended before.
  if (several_hosts && (!kill || !machine_.stopping->terminate_at)) Search();
}

}  // namespace musher
