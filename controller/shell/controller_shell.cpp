#include "musher/controller/shell/controller_shell.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/break_watch.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/lifecycle/rules/policy_requests.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/lifecycle/switch/switches.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr Duration kLastAnswers = Milliseconds(3000);  // a client's discovery may be incomplete
constexpr Duration kHeldPeriod = Milliseconds(5);
constexpr Duration kStopTime = Milliseconds(1000);  // a body that stops is not named as moving on

}  // namespace

ControllerShell::ControllerShell(Dependencies dependencies, const MachineConfig& config,
                                 Hooks hooks)
    : dependencies_(std::move(dependencies)),
      config_(config),
      hooks_(std::move(hooks)),
      machine_(MakeMachine(config)),
      records_(dependencies_.node->loop(), *dependencies_.journal, dependencies_.wall_ns, config,
               machine_, hooks_.on_record),
      context_{dependencies_, config, machine_, records_,
               [this](const Event& event) { Handle(event); }},
      recorder_(*dependencies_.journal, config),
      peers_(std::make_unique<ActuatorPeers>(context_)),
      moves_on_since_(config.actuators.size()) {
  if (!dependencies_.rules.empty()) rules_.emplace(config_, dependencies_.rules);
}

ControllerShell::~ControllerShell() {
  peers_->Unsubscribe();  // before what its callbacks use
}

Result<std::unique_ptr<ControllerShell>> ControllerShell::Make(Dependencies dependencies,
                                                               const MachineConfig& config,
                                                               Hooks hooks) {
  std::unique_ptr<ControllerShell> shell(
      new ControllerShell(std::move(dependencies), config, std::move(hooks)));
  if (auto opened = shell->Open(); !opened) return opened.error();
  return shell;
}

Result<> ControllerShell::Open() {
  transport::Node& node = *dependencies_.node;
  if (auto opened = peers_->OpenLinks(); !opened) return opened;
  auto presence = ControllerPresence::Make(
      node, config_,
      {dependencies_.incarnation, dependencies_.pid, dependencies_.host, dependencies_.host_name,
       dependencies_.machine_id},
      context_.handle, [this](const ControllerPresence::Rival* other) { OnOtherMachine(other); });
  if (!presence) return presence.error();
  presence_ = std::move(presence).value();
  board_ = std::make_unique<MachineBoard>(context_, *presence_);
  auto health = HealthWatch::Make(
      node, config_, *dependencies_.process_probe, dependencies_.host,
      [this](const event::HealthChanged& changed) {
        // What happens to a process that another machine has taken does not count here.
        if (!peers_->FollowsOther(changed.actuator)) context_.handle(changed);
      },
      [this](ActuatorIndex i) {
        peers_->LinkTo(i).Query({machine_.epoch, 0, false});  // this query fences nothing
      },
      [this](ActuatorIndex i, Incarnation incarnation) { peers_->OnAlive(i, incarnation); });
  if (!health) return health.error();
  health_ = std::move(health).value();
  processes_ = std::make_unique<ActuatorProcesses>(context_, *presence_, *health_, *peers_);
  auto inputs = PolicyInputs::Make(node, config_, context_.handle);
  if (!inputs) return inputs.error();
  policy_inputs_ = std::move(inputs).value();
  return peers_->Subscribe(*health_);
}

// --- the begin of the machine, and its clients ---

void ControllerShell::Begin(event::Begin begin, const std::vector<ChildProcess>& children) {
  if (const auto opened = OpenToClients(); !opened) return Refuse(opened.error());
  recorder_.Begin(dependencies_.wall_ns(), dependencies_.config_text);
  begin.host = dependencies_.host;
  const StoredStops received = std::exchange(stops_before_begin_, {});
  begin.stops = Merge(begin.stops, WithoutReleased(begin.stops, received));
  if (const auto& replaced = rival()) {
    begin.stops.awaits_request |= replaced->awaits_request;
    begin.supervised = true;  // it goes on with what that one leads, and requests nothing
  }
  // Actuators of another host are only known by their status.
  begin.running.resize(config_.actuators.size());
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (peers_->RanBeforeBegin(i)) begin.running[i] = true;
  }
  processes_->TakeOver(begin, children);
  Handle(begin);
  peers_->Begin();
  processes_->OpenHosts();
  if (policy_inputs_) policy_inputs_->Begin();
  if (journal_at_begin_) OnJournalWritten(*journal_at_begin_);
  if (const auto after = std::exchange(tear_down_at_begin_, std::nullopt)) TearDown(*after);
}

Result<> ControllerShell::OpenToClients() {
  if (auto opened = board_->Open(); !opened) return opened;
  if (hooks_.open_services) {
    if (auto opened = hooks_.open_services(); !opened) return opened;
  }
  return board_->Announce();
}

// Requests that still wait for an answer get `why` first.
void ControllerShell::CloseToClients(const Error& why) {
  for (auto& [request, done] : std::exchange(waiting_for_answer_, {})) done(why);
  for (auto& [request, done] : std::exchange(waiting_for_result_, {})) {
    if (done) done(RefusedSwitch({}, "", machine_.state, why));
  }
  board_->Close();
  if (hooks_.close_services) hooks_.close_services();
}

void ControllerShell::CloseOnceAnswered(Time deadline) {
  const Time now = dependencies_.node->loop().Now();
  const bool holds = hooks_.holds_answers && hooks_.holds_answers() && now < deadline;
  const auto next = [this, deadline, holds] {
    if (holds) return CloseOnceAnswered(deadline);
    CloseToClients(Refused<Refusal::kMachineStopped>());
  };
  close_later_ = dependencies_.node->loop().At(holds ? now + kHeldPeriod : now, next);
}

void ControllerShell::Refuse(const Error& why) {
  refused_ = why;
  CloseToClients(why);
  if (hooks_.on_fenced) hooks_.on_fenced(why.message);
}

void ControllerShell::ReleaseControl(const std::string& rival, bool elsewhere) {
  if (machine_.phase == Phase::kIdle) {
    return Refuse(Refused<Refusal::kRivalTakesOver>(rival));
  }
  Handle(event::RivalSeen{machine_.epoch + 1, rival, true, elsewhere});
}

void ControllerShell::SetMachineId(const std::string& id) {
  presence_->SetMachineId(id);
  peers_->SetMachine(machine_identity());
}

bool ControllerShell::IsOtherMachine(const MachineIdentity& machine) const {
  if (SameMachine(machine_identity(), machine)) return false;
  const std::vector<ControllerPresence::Rival> others = presence_->OtherMachines();
  return std::any_of(others.begin(), others.end(), [&](const ControllerPresence::Rival& other) {
    return SameMachine(other.machine, machine);
  });
}

void ControllerShell::OnOtherMachine(const ControllerPresence::Rival* other) {
  if (other != nullptr) {
    records_.WriteOwn(
        "machine", std::nullopt, kCodeParametersInvalid,
        texts::OtherMachineSeen(MachineText(other->machine), other->process, config_.name_space));
  }
  board_->PublishSoon();
}

// --- requests ---

std::optional<Error> ControllerShell::MeantForAnother(transport::ParticipantId caller) const {
  const MachineIdentity* other = peers_->OtherMachineOf(caller);
  if (other == nullptr) return std::nullopt;
  return Refused<Refusal::kRequestOfOtherMachine>(MachineText(*other),
                                                  MachineText(machine_identity()));
}

std::optional<Error> ControllerShell::MayBeLate() const {
  const auto could_not_run = presence_->RecentBreak();
  if (!could_not_run) return std::nullopt;
  return Refused<Refusal::kMayBeLate>(ToMilliseconds(*could_not_run) / 1000);
}

std::optional<Error> ControllerShell::MayBeLate(const State& target,
                                                std::optional<ActuatorIndex> only) const {
  const auto late = MayBeLate();
  if (!late) return std::nullopt;
  const Plan plan = MakePlan(config_, machine_, target, only);
  return OnlyLowers(config_, machine_, plan) ? std::nullopt : late;
}

void ControllerShell::RecordLate(const State& target, std::optional<ActuatorIndex> only,
                                 const Error& late) {
  RecordLate("switch", only, late,
             texts::SwitchRefused(Describe(config_, target.Shortened(), only), late.message));
}

void ControllerShell::RecordLate(const event::PolicyRequested& requested, const Error& late) {
  RecordLate("policy", std::nullopt, late, texts::PolicyRefused(Describe(requested), late.message));
}

void ControllerShell::RecordLateRestart(const std::string& actuator, const Error& late) {
  RecordLate("process", config_.IndexOf(actuator), late,
             texts::RequestRefused("restart of " + actuator.substr(0, 64), late.message));
}

void ControllerShell::RecordLateRelease(const Error& late) {
  RecordLate("machine", std::nullopt, late,
             texts::RequestRefused("release of the emergency stop", late.message));
}

// What a stop of this process has delayed arrives within kArriveWithin after it, so later refusals
// are of another stop.
void ControllerShell::RecordLate(const std::string& kind, std::optional<ActuatorIndex> actuator,
                                 const Error& late, const RecordText& text) {
  CheckThread();
  const Time now = dependencies_.node->loop().Now();
  if (now - recorded_late_at_ > BreakWatch::kArriveWithin) recorded_late_.clear();
  if (recorded_late_.empty()) recorded_late_at_ = now;
  const bool known = std::ranges::count(recorded_late_, text.message) != 0;
  if (known || recorded_late_.size() >= kMostLate) return;
  recorded_late_.push_back(text.message);
  records_.WriteOwn(kind, actuator, late.code, text);
}

RequestId ControllerShell::NewAnswer(OnAnswer done) {
  const RequestId request = next_request_++;
  waiting_for_answer_[request] = std::move(done);
  return request;
}

void ControllerShell::SetState(const State& target, const std::optional<std::string>& actuator,
                               OnResult done, const Requester& by) {
  CheckThread();
  if (refused_) return done(RefusedSwitch({}, "", machine_.state, *refused_));
  const RequestId request = next_request_++;
  waiting_for_result_[request] = std::move(done);
  Handle(event::SetStateRequested{request, target, actuator, AfterTearDown::kStaysDown, by});
}

void ControllerShell::TearDown(AfterTearDown after) {
  CheckThread();
  if (machine_.phase == Phase::kIdle) {
    tear_down_at_begin_ = after;
    return;
  }
  Handle(event::SetStateRequested{next_request_++, State(kTearDown), std::nullopt, after});
}

void ControllerShell::AwaitSetUp(OnAnswer done) {
  CheckThread();
  if (refused_) return done(*refused_);
  Handle(event::SetUpAwaited{NewAnswer(std::move(done))});
}

void ControllerShell::Restart(const std::string& actuator, const std::string& by, OnAnswer done) {
  CheckThread();
  if (refused_) return done(*refused_);
  Handle(event::RestartRequested{NewAnswer(std::move(done)), actuator, by});
}

void ControllerShell::ReleaseEmergencyStop(const std::string& by, OnAnswer done,
                                           std::vector<StopId> seen) {
  CheckThread();
  if (refused_) return done(*refused_);
  Handle(event::ReleaseRequested{NewAnswer(std::move(done)), by, std::move(seen)});
}

void ControllerShell::SendPolicyRequest(event::PolicyRequested requested, OnAnswer done) {
  CheckThread();
  if (refused_) return done(*refused_);
  requested.request = NewAnswer(std::move(done));
  Handle(requested);
}

void ControllerShell::Remark(std::int32_t code, const std::string& message) {
  CheckThread();
  records_.Remark(code, message);
}

// --- events and actions ---

void ControllerShell::CheckThread() const {
  dependencies_.node->loop().CheckThread();
}

// Keeps events from before Begin(), which nothing would repeat.
bool ControllerShell::KeepForBegin(const Event& event) {
  if (machine_.phase != Phase::kIdle) return false;
  if (const auto* stop = std::get_if<event::EmergencyStopSeen>(&event)) {
    if (stop->engaged) {
      AddReceived(stops_before_begin_, stop->stop);
    } else {
      AddReceivedRelease(stops_before_begin_, stop->stop.id);
    }
    return true;
  }
  return peers_->KeepForBegin(event);
}

// Handles events one after the other: a callback that gets an answer may send a new request.
void ControllerShell::Handle(const Event& event) {
  CheckThread();
  if (KeepForBegin(event)) return;
  // Every event may begin a time of the policy: the end of a switch begins the time of lying still.
  if (policy_inputs_ && !handling_) policy_inputs_->EmitTime();
  queue_.push_back(event);
  if (handling_) return;
  handling_ = true;
  HandleQueued();
  handling_ = false;
  ArmTimer();
  CheckRules();
  ShowNotStopped();
  board_->Refresh();
}

// "arm: the brake does not answer": of a stop whose command or panel has ended, nothing else says
// that an actuator has latched it, and moves on. Each that stops needs some time for it.
void ControllerShell::ShowNotStopped() {
  const Time now = dependencies_.node->loop().Now();
  std::vector<std::string> actuators;
  std::optional<Time> next;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string why = machine_.emergency.stop ? peers_->StopTrouble(i) : "";
    std::optional<Time>& since = moves_on_since_[i];
    if (why.empty()) {
      since.reset();
      continue;
    }
    if (!since) since = now;
    const Time named_at = *since + kStopTime;
    if (now >= named_at) {
      actuators.push_back(config_.actuators[i].name + ": " + why);
    } else if (!next || named_at < *next) {
      next = named_at;
    }
  }
  board_->SetNotStopped(std::move(actuators));
  not_stopped_timer_ = nullptr;
  if (!next) return;
  not_stopped_timer_ = dependencies_.node->loop().At(*next, [this] {
    ShowNotStopped();
    board_->Refresh();
  });
}

void ControllerShell::HandleQueued() {
  while (!queue_.empty()) {
    const Event event = std::move(queue_.front());
    queue_.pop_front();
    if (std::holds_alternative<event::TimePassed>(event)) {
      const Time now = dependencies_.node->loop().Now();
      for (const auto& examined : processes_->OverdueStarts(machine_, now)) HandleOne(examined);
    }
    HandleOne(event);
  }
}

void ControllerShell::HandleOne(const Event& event) {
  const Time now = dependencies_.node->loop().Now();
  recorder_.Note(dependencies_.wall_ns(), machine_, event, now);
  const std::vector<Action> actions = Step(config_, machine_, event, now);
  const EmergencyStopState& emergency = machine_.emergency;
  presence_->SetAwaitsRequest(emergency.awaits_request || emergency.Unanswered() != nullptr);
  for (const Action& action : actions) {
    std::visit([this](const auto& a) { Do(a); }, action);
  }
}

void ControllerShell::ArmTimer() {
  if (policy_inputs_) policy_inputs_->WakeAt(NextPolicyDeadline(config_, machine_));
  const std::optional<Time> next = NextDeadline(config_, machine_);
  if (next == armed_for_) return;
  armed_for_ = next;
  timer_ = nullptr;
  if (!next) return;
  timer_ = dependencies_.node->loop().At(*next, [this] {
    armed_for_.reset();
    Handle(event::TimePassed{});
  });
}

void ControllerShell::CheckRules() {
  if (!rules_) return;
  for (const auto& violation : rules_->Check(machine_, dependencies_.node->loop().Now())) {
    records_.WriteOwn("machine", std::nullopt, kCodeFailed,
                      texts::RuleViolated(violation.rule, violation.states));
  }
  board_->SetViolatedRules(rules_->violated());
  const std::optional<Time> next = rules_->next_check();
  if (next == rules_armed_for_) return;
  rules_armed_for_ = next;
  rules_timer_ = nullptr;
  if (!next) return;
  rules_timer_ = dependencies_.node->loop().At(*next, [this] {
    rules_armed_for_.reset();
    CheckRules();
  });
}

void ControllerShell::Do(const action::SendSwitch& a) {
  if (hooks_.on_send) hooks_.on_send(a);
  peers_->LinkTo(a.actuator).Switch(a.command);
}

void ControllerShell::Do(const action::SendQuery& a) {
  // A new actuator obeys only a controller whose heartbeat it has received.
  if (machine_.actuators[a.actuator].presence != Presence::kPresent) presence_->Repeat();
  peers_->LinkTo(a.actuator).Query(a.command);
}

void ControllerShell::Do(const action::RunPowerCommand& a) {
  if (hooks_.on_power) hooks_.on_power(a.reboot);
  processes_->Do(a);
}

void ControllerShell::Do(const action::AnswerSetState& a) {
  const auto waiting = waiting_for_result_.extract(a.request);
  if (!waiting.empty() && waiting.mapped()) waiting.mapped()(a.result);
}

void ControllerShell::Do(const action::AnswerCall& a) {
  const auto waiting = waiting_for_answer_.extract(a.request);
  if (!waiting.empty()) waiting.mapped()(a.result);
}

void ControllerShell::Do(const action::PublishEmergencyStop& a) {
  presence_->Publish(a);
  if (!machine_.emergency.stop) presence_->ForgetEngaged();
}

ControllerShell::Dependencies::OnSaved ControllerShell::OnSaved(Stored what, SaveNumber save) {
  return [this, what, save](const Result<>& saved) {
    Handle(event::SaveEnded{what, save, saved.ok(), saved ? "" : saved.error().message});
  };
}

void ControllerShell::OnJournalWritten(const Result<>& written) {
  if (machine_.phase == Phase::kIdle) {
    journal_at_begin_ = written;
  } else {
    OnSaved(Stored::kJournal, 0)(written);
  }
}

void ControllerShell::Do(const action::SaveEmergencyStops& a) {
  dependencies_.save_emergency_stops(a.stops, OnSaved(Stored::kEmergencyStops, a.save));
}

void ControllerShell::Do(const action::SaveEpoch& a) {
  presence_->Announce(a.epoch);
  dependencies_.save_epoch(a.epoch, OnSaved(Stored::kEpoch, a.save));
}

void ControllerShell::Do(const action::SavePolicy& a) {
  dependencies_.save_policy(a.policy, OnSaved(Stored::kPolicy, a.save));
}

void ControllerShell::Do(const action::SaveStopIntent& a) {
  dependencies_.save_stop_intent(a.intended, OnSaved(Stored::kStopIntent, a.save));
}

void ControllerShell::Do(const action::SaveRemoteActuators& a) {
  dependencies_.save_remote_actuators(a.actuators, OnSaved(Stored::kRemoteActuators, a.save));
}
void ControllerShell::Do(const action::SaveActuators& a) {
  dependencies_.save_actuators(a.actuators, OnSaved(Stored::kActuators, a.save));
}

void ControllerShell::Do(const action::Fenced& a) {
  processes_->CancelStarts();
  presence_->FallSilent();
  CloseToClients({kCodePermissionDenied, a.message});
  if (hooks_.on_fenced) hooks_.on_fenced(a.message);
}

void ControllerShell::Do(const action::StartUpEnded& a) {
  if (hooks_.on_start_up_ended) hooks_.on_start_up_ended(a);
}

// The cause may be a request that is still being handled: its service closes after its reply.
void ControllerShell::Do(const action::Stopped&) {
  processes_->CancelStarts();  // what runs from now on is the next controller's
  PublishStatus();
  presence_->FallSilent();
  CloseOnceAnswered(dependencies_.node->loop().Now() + kLastAnswers);
  if (hooks_.on_stopped) hooks_.on_stopped();
}

}  // namespace musher
