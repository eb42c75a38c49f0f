#include "musher/lifecycle/supervision/start_up.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/policy/policy.hpp"
#include "musher/lifecycle/supervision/adoption.hpp"
#include "musher/lifecycle/switch/plan.hpp"

namespace musher {
namespace {

// The record that Begin makes is the first one.
constexpr RecordId kBegun = 1;

std::string StopsUnreadIn(const UnreadFolder& unread) {
  return "an emergency stop may be engaged in " + unread.folder + ": " + WhyUnread(unread) +
         "; check the robot, then run `musher set SelfCheck` and `musher set Active`";
}

}  // namespace

void StartUp::Begin(const event::Begin& begin) {
  machine_.phase = Phase::kStarting;
  machine_.start_up.by_hand = begin.by_hand || config_.ros2.started_by_manager;
  machine_.host = begin.host;
  machine_.epoch = begin.epoch + 1;
  machine_.start_up.finishing = begin.stop_intent && begin.restarted;
  machine_.start_up.by_supervisor = begin.restarted || begin.at_boot;
  machine_.start_up.restarted = machine_.start_up.by_supervisor && begin.epoch > 0;
  machine_.start_up.requests_nothing = begin.supervised || begin.restarted;
  saver_.Save(Stored::kEpoch);
  for (const ActuatorIndex i : begin.running.Indices()) {
    if (!begin.running[i]) continue;
    Of(i).process.launch = Launch::kFoundRunning;
    // An earlier controller has started it: this one takes over, and begins nothing.
    machine_.start_up.requests_nothing |= !ConfigOf(i).command.empty();
  }
  for (const ActuatorIndex i : begin.processes.Indices()) Of(i).process.pid = begin.processes[i];
  for (const RemoteActuator& remote : begin.remote) {
    if (const auto i = config_.IndexOf(remote.name)) Of(*i).elsewhere = remote.host;
  }
  RecordMachine(kCodeOk, texts::ControllerStarted(machine_.epoch, machine_.actuators.size()));
  machine_.saves.actuators = begin.actuators;
  TakeUp(WithEnded(begin));
  if (machine_.start_up.finishing) {
    RecordMachine(kCodeOk, texts::TearDownResumedBySupervisor(), kBegun);
  } else if (begin.stop_intent) {
    saver_.Save(Stored::kStopIntent);  // clears the intent
  }
  StartStage(machine_.start_up.by_hand || machine_.start_up.finishing ? LastStage(config_) : 1,
             kBegun);
}

// What was stored, with what has ended since the controller that stored it. The config may forbid
// that such an actuator is restarted: it would be, by the restart of the controller. Where nothing
// runs the machine starts from the beginning.
std::vector<StoredActuator> StartUp::WithEnded(const event::Begin& begin) const {
  std::vector<StoredActuator> actuators = begin.actuators;
  const bool any_runs = std::ranges::find(begin.running, true) != begin.running.end();
  for (const ActuatorIndex i : begin.ended.Indices()) {
    if (!begin.ended[i]) continue;
    const std::string& name = ConfigOf(i).name;
    auto found = std::ranges::find(actuators, name, &StoredActuator::name);
    if (found == actuators.end()) found = actuators.insert(found, StoredActuator{name});
    if (found->stays_down == StaysDown::kTornDown) continue;  // it has ended after its TearDown
    if (found->lost_in.empty()) found->lost_in = State(kUnknownState);
    if (any_runs && !MayRestart(i)) found->stays_down = StaysDown::kGivenUp;
  }
  return actuators;
}

// What a person has torn down alone or holds, and what was given up, comes on by no restart of the
// controller and by no boot, but by a start of the person.
void StartUp::TakeUp(const std::vector<StoredActuator>& actuators) {
  const bool by_itself = machine_.start_up.requests_nothing || machine_.start_up.by_supervisor;
  for (const StoredActuator& stored : actuators) {
    const auto i = config_.IndexOf(stored.name);
    if (!i) continue;
    KnownActuator& known = Of(*i);
    known.lost_in = stored.lost_in;
    if (by_itself && IsPlace(stored.kept_in)) known.kept_in = stored.kept_in;
    const bool stays = stored.stays_down != StaysDown::kNo && by_itself;
    if (stays && ConfigOf(*i).command.empty()) {
      known.down_requested = true;
      continue;
    }
    const bool runs = known.process.launch == Launch::kFoundRunning;
    if (!stays || machine_.start_up.finishing) continue;
    if (runs && stored.stays_down == StaysDown::kTornDown) {  // its process is about to exit
      known.down_requested = true;
      known.held = true;
      Degrade(*i, kCodeStateInvalid, texts::TornDownAlone(), kBegun);
    }
    if (runs) continue;
    known.presence = Presence::kLost;
    if (!known.lost_in.empty()) known.report.state = known.lost_in;
    if (stored.stays_down == StaysDown::kTornDown) {
      known.report.state = State(kTearDown);
      known.report.detached = true;
      known.held = true;
      Degrade(*i, kCodeStateInvalid, texts::TornDownAlone(), kBegun);
    } else {
      known.restart.given_up = true;
      Degrade(*i, kCodeFailed, texts::GivenUpBefore(known.lost_in), kBegun);
    }
  }
}

void StartUp::StartStage(int stage, RecordId cause) {
  machine_.start_up.stage = stage;
  if (stage > 1 && !machine_.start_up.by_hand) {
    cause = RecordMachine(kCodeOk, texts::StageStarted(stage), cause);
  }
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    const bool waited_for =
        ConfigOf(i).command.empty() || known.process.launch == Launch::kFoundRunning;
    if (!IsAwaitedIn(i, stage) || known.presence == Presence::kPresent || known.set_up_by) continue;
    known.cause = cause;
    const Duration set_up = config_.TimeFor(i, kSetUp);
    const Duration timeout =
        machine_.start_up.finishing ? std::min(set_up, kLongestDiscovery) : set_up;
    // Only a Musher process holds its actuator's name, by which it is found running.
    const bool may_run = machine_.start_up.finishing && ConfigOf(i).protocol != Protocol::kMusher;
    if (waited_for || may_run) known.set_up_by = now_ + timeout;
  }
}

bool StartUp::StartProcesses() {
  if (machine_.start_up.finishing) return false;
  bool changed = false;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    const ActuatorConfig& actuator = ConfigOf(i);
    const bool blocked = known.process.launch == Launch::kBlocked;
    if (actuator.stage > machine_.start_up.stage || actuator.command.empty() ||
        known.process.launch == Launch::kFoundRunning || known.presence != Presence::kAbsent ||
        known.set_up_by || (known.fault && !blocked)) {
      continue;
    }
    std::optional<RecordText> blocker;
    if (!NeedsMet(i, blocker)) {
      if (!blocker) blocker = WaitsForSuspended(i);
      if (!blocker || blocked) continue;
      known.process.launch = Launch::kBlocked;
      Degrade(i, kCodeStatusError, *blocker, CauseOfBlocker(i));
      FallBack(i);
    } else {
      if (blocked) known.fault.reset();
      known.presence = Presence::kStarting;
      known.set_up_by = now_ + config_.TimeFor(i, kSetUp);
      known.process.launch = Launch::kUnderWay;
      Do(action::StartProcess{i});
    }
    changed = true;
  }
  return changed;
}

bool StartUp::Advance() {
  if (!machine_.start_up.set_up && machine_.phase == Phase::kStarting) {
    // TearDown itself waits for the others; what is torn down may exit before they are there.
    if (!machine_.start_up.finishing && Adoption(config_, machine_).FoundTearDown()) {
      AdoptFrom(State(kTearDown), kBegun);
      return true;
    }
    if (!StageIsSetUp(machine_.start_up.stage) || AwaitsHost()) return false;
    EndFirstStage();
    return true;
  }
  const bool more =
      machine_.phase == Phase::kRunning && machine_.start_up.stage < LastStage(config_);
  if (!more || machine_.current || !StageIsSettled(machine_.start_up.stage)) return false;
  StartStage(machine_.start_up.stage + 1, kBegun);
  return true;
}

// Whether a critical actuator is on a host that has not been reached yet: a board that boots later
// than this one would end the start at each power-on. Until `set_up_by`: what is plugged in hours
// later moves no robot. What an earlier controller has left running
// is led on at once.
bool StartUp::AwaitsHost() const {
  if (machine_.start_up.finishing || Adoption(config_, machine_).LowestFound()) return false;
  return std::ranges::any_of(machine_.actuators.Indices(), [this](ActuatorIndex i) {
    return Critical(i) && IsAwaitedIn(i, machine_.start_up.stage) &&
           Of(i).process.launch == Launch::kAwaitsHost && Of(i).presence == Presence::kAbsent &&
           Of(i).set_up_by;
  });
}

// All actuators of the first stage are set up, or given up.
void StartUp::EndFirstStage() {
  machine_.start_up.set_up = true;
  machine_.state = State(kSetUp);
  std::vector<std::string> missing;
  std::size_t present = 0;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const KnownActuator& known = Of(i);
    if (known.fault) missing.push_back(ConfigOf(i).name + ": " + known.fault->message);
    if (known.presence == Presence::kPresent && !IsUnconfigured(config_, i, known)) ++present;
  }
  AnswerSetUpRequests();
  const RecordId recorded = RecordMachine(kCodeOk, texts::ActuatorsSetUp(present), kBegun);
  if (machine_.start_up.finishing) return AdoptFrom(State(kTearDown), recorded);
  if (const auto lowest = Adoption(config_, machine_).LowestFound())
    return AdoptFrom(*lowest, recorded);
  if (machine_.start_up.requests_nothing && Adoption(config_, machine_).FoundInSelfCheck()) {
    return Fail(
        "it was found in SelfCheck, from where a person leads it on; run `musher set "
        "SelfCheck` and `musher set Active`",
        recorded);
  }
  const bool stopped = machine_.emergency.stop.has_value();
  const bool waits = machine_.emergency.awaits_request && machine_.start_up.requests_nothing;
  if (config_.ros2.started_by_manager) {
    const bool known = machine_.emergency.Unanswered() == nullptr;
    if (!stopped && !waits && known) stops_.TakeRequest();
    return WaitForManager(present, std::move(missing), recorded);
  }
  if (machine_.start_up.by_hand) return;
  if (present == 0) {
    return Fail(missing.empty() ? "there is no actuator in stage 1" : missing.front(), recorded);
  }
  if (stopped) {
    return Fail(
        "an emergency stop is engaged; run `musher estop --release`, then `musher set SelfCheck` "
        "and `musher set Active`",
        recorded);
  }
  if (waits) return FailWithoutRequest(recorded);
  // A person who starts it does not know of a stop that this start cannot read.
  if (const UnreadFolder* unread = machine_.emergency.Unanswered()) {
    return Fail(StopsUnreadIn(*unread), recorded);
  }
  stops_.TakeRequest();  // the start is a person's, and begins with the first state
  if (!config_.HasState(kSelfCheck)) return Activate(recorded);
  switches_.Begin(MakePlan(config_, machine_, State(kSelfCheck)), Purpose::kStartUpCheck, {},
                  recorded);
}

// A release switches nothing on, nor does a start that was begun before.
void StartUp::FailWithoutRequest(RecordId cause) {
  Fail(
      "no state was requested since the last emergency stop; run `musher set SelfCheck` and "
      "`musher set Active`",
      cause);
}

void StartUp::WaitForManager(std::size_t present, std::vector<std::string> missing,
                             RecordId cause) {
  if (FailOnCriticalFault()) return;
  if (present == 0) {
    return Fail(missing.empty() ? "the machine has no actuator" : missing.front(), cause);
  }
  if (const UnreadFolder* unread = machine_.emergency.Unanswered()) {
    missing.push_back(StopsUnreadIn(*unread));
  }
  const RecordText text = texts::WaitingForManager(missing);
  RecordMachine(kCodeOk, text, cause);
  Do(action::StartUpEnded{true, text.message});
}

// Returns whether a critical actuator of the stages so far has a fault.
bool StartUp::FailOnCriticalFault() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (ConfigOf(i).stage > machine_.start_up.stage || !Critical(i) || !Of(i).fault) continue;
    Fail("critical " + ConfigOf(i).name + ": " + CodeText(Of(i).fault->code) + ", " +
             Of(i).fault->message,
         Of(i).cause);
    return true;
  }
  return false;
}

void StartUp::OnSwitchEnded(const EndedSwitch& ended) {
  if (ended.purpose == Purpose::kStartUpCheck) {
    if (!FailOnCriticalFault()) Activate(ended.record);
    return;
  }
  if (ended.purpose == Purpose::kStartUpActivate && ended.undone) {
    return Fail(ended.result.reason, ended.record);
  }
  if (!ended.of_machine || ended.undone || !config_.RankOf(machine_.state)) return;
  if (machine_.phase == Phase::kStarting || machine_.phase == Phase::kFailed) {
    const std::string trouble = ended.result.degraded.empty() ? "" : FirstTrouble();
    BecomeRunning(texts::MachineUsable(machine_.state, trouble), ended.record);
  }
}

// By itself a machine goes no higher than DeActive while an emergency stop would not outlive its
// controller. A person may overrule that. The same holds while its battery is too low for Active,
// or was when it was last known; from there the rule of the battery leads on.
void StartUp::Activate(RecordId cause) {
  // An actuator that an earlier controller has left, and that was found in the steps of this start:
  // nothing rises beyond it.
  if (machine_.start_up.requests_nothing) {
    if (const auto lowest = Adoption(config_, machine_).LowestFound())
      return AdoptFrom(*lowest, cause);
  }
  if (!config_.HasState(kActive)) {
    return BecomeRunning(texts::MachineUsableWithoutActive(), cause);
  }
  // A stop was engaged and released after the start had taken its request.
  if (machine_.emergency.awaits_request && !machine_.emergency.stop) {
    return FailWithoutRequest(cause);
  }
  PolicyState& policy = machine_.policy;
  const std::string unsaved = WhyNotSaved(Stored::kEpoch);
  const bool battery_low = policy.level != BatteryLevel::kFree;
  State target(kActive);
  if (!unsaved.empty()) {
    const RecordText text = texts::StateNotWritable(unsaved);
    if (!config_.HasState(kDeActive)) return Fail(text.message, cause);
    cause = RecordMachine(kCodeFailed, text, cause);
    target = kDeActive;
  } else if (battery_low) {
    const std::string limit = AboveCeiling(config_, policy, policy.level).message;
    if (!config_.HasState(kDeActive)) return Fail(limit, cause);
    target = kDeActive;
    cause = RecordMachine(kCodeOk, texts::BatteryLimitsStart(limit, target), cause);
  }
  const Plan plan = MakePolicyPlan(config_, machine_, target);
  if (plan.refusal) return Fail(plan.refusal->message, cause);
  switches_.Begin(plan, Purpose::kStartUpActivate, {}, cause);
  if (unsaved.empty() && battery_low) policy.withheld = BatteryFallback{State(kActive), target, 0};
}

// Empty: it is on disk, or not known to have failed.
std::string StartUp::WhyNotSaved(Stored what) const {
  const auto& unsaved = machine_.saves.unsaved;
  const auto found = std::ranges::find(unsaved, what, &Unsaved::what);
  return found == unsaved.end() ? "" : found->why;
}

void StartUp::Fail(const std::string& why, RecordId cause) {
  machine_.phase = Phase::kFailed;
  const RecordText text = texts::StartUpFailed(machine_.state, why);
  RecordMachine(kCodeFailed, text, cause);
  Do(action::StartUpEnded{false, text.message});
}

// An earlier controller left actuators running: the machine continues from the least active state,
// so that no actuator becomes more active by a restart; the others are driven there.
void StartUp::AdoptFrom(const State& lowest, RecordId cause) {
  if (lowest == kTearDown) {
    const RecordText text = texts::TearDownResumed();
    const RecordId recorded = RecordMachine(kCodeOk, text, cause);
    Do(action::StartUpEnded{false, text.message});
    return tear_down_.Begin(MakePlan(config_, machine_, lowest), {}, recorded);
  }
  machine_.state = lowest;
  // It is not known who has requested that: a manager continues from there only down.
  if (config_.RankOf(lowest)) machine_.standing = StandingRequest{lowest, "an earlier controller"};
  const Adoption adoption(config_, machine_);
  if (const std::string elsewhere = adoption.Elsewhere(); !elsewhere.empty()) {
    cause =
        RecordMachine(kCodeOk,
                      adoption.FoundSwitching() ? texts::UnfinishedSwitchFound(elsewhere, lowest)
                                                : texts::MixedStatesFound(elsewhere, lowest),
                      cause);
  }
  BecomeRunning(texts::MachineAdopted(lowest), cause);
}

void StartUp::BecomeRunning(const RecordText& text, RecordId cause) {
  machine_.phase = Phase::kRunning;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    const bool there = known.presence == Presence::kPresent;
    if (there && MayFollow(i) && !known.held && known.state() != machine_.state) {
      known.due = true;
    }
    const bool away = !there || IsUnconfigured(config_, i, known);
    if (away && known.fault && !known.held && !IsComing(i)) FallBack(i);
  }
  RecordMachine(kCodeOk, text, cause);
  Do(action::StartUpEnded{true, text.message});
}

// The fault of the first degraded actuator; there is one.
std::string StartUp::FirstTrouble() const {
  const std::string name = Degraded(config_, machine_).front();
  return name + ": " + TroubleOf(Of(*config_.IndexOf(name)))->message;
}

void StartUp::On(const event::SetUpAwaited& awaited) {
  machine_.start_up.requests.push_back(awaited.request);
  if (machine_.start_up.set_up) AnswerSetUpRequests();
}

void StartUp::AnswerSetUpRequests() {
  Result<> answer;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (!answer) break;
    const auto& fault = Of(i).fault;
    if (fault) answer = Error{kCodeTimeout, ConfigOf(i).name + ": " + fault->message};
  }
  for (const RequestId request : std::exchange(machine_.start_up.requests, {})) {
    Do(action::AnswerCall{request, answer});
  }
}

// --- actuators that are not set up in time, and why ---

void StartUp::CheckDeadlines() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    GiveUpIfOverdue(i, StartProgress::kUnknown);
  }
}

void StartUp::On(const event::StartExamined& examined) {
  if (Of(examined.actuator).process.pid != examined.pid) return;
  GiveUpIfOverdue(examined.actuator, examined.progress);
}

void StartUp::GiveUpIfOverdue(ActuatorIndex i, StartProgress progress) {
  if (!IsOverdue(Of(i), now_)) return;
  KnownActuator& known = Of(i);
  known.set_up_by.reset();
  if (known.fault && known.presence != Presence::kStarting) return;  // the known fault says more
  if (machine_.start_up.finishing) return;  // an actuator that does not run need not be torn down
  // The reason of a failed SetUp says more as well.
  const ActuatorReport& report = known.report;
  const bool failed = known.fault && report.incarnation != known.process.dead &&
                      report.state == config_.default_state && report.outcome_code != kCodeOk;
  if (!failed) Degrade(i, kCodeTimeout, NotSetUp(i, progress), known.cause);
  FallBack(i);
}

// Why it is not set up by its deadline.
RecordText StartUp::NotSetUp(ActuatorIndex i, StartProgress progress) const {
  const ActuatorConfig& actuator = ConfigOf(i);
  const KnownActuator& known = Of(i);
  const Duration within = config_.TimeFor(i, kSetUp);
  const bool announced =
      known.report.incarnation != 0 && known.report.incarnation != known.process.dead;
  if (actuator.protocol == Protocol::kRos2Lifecycle && !announced) {
    const std::string folder = config_.name_space.empty() ? "/" : "/" + config_.name_space + "/";
    return texts::NodeNotDiscovered(folder + actuator.name, within, known.process.pid);
  }
  if (known.process.pid == 0 || announced || actuator.protocol != Protocol::kMusher) {
    return texts::SetUpTimeout(within);
  }
  for (const ActuatorIndex other : machine_.actuators.Indices()) {
    const bool shared = Of(other).process.pid == known.process.pid &&  // `i` itself is not present
                        Of(other).process.host == known.process.host;
    if (!shared || Of(other).presence != Presence::kPresent) continue;
    return texts::NotAnnouncedBeside(actuator.name, ConfigOf(other).name, within,
                                     known.process.pid);
  }
  return texts::NotAnnounced(actuator.name, actuator.command, within, known.process.pid, progress);
}

}  // namespace musher
