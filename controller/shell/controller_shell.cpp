#include "musher/controller/shell/controller_shell.hpp"

#include <algorithm>
#include <utility>

#include "musher/controller/journal/record_data.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr std::size_t kSwitchEntriesKept = 128;        // two for each switch: begin and end
constexpr Duration kLastAnswers = Milliseconds(3000);  // a client's discovery may be incomplete
constexpr Duration kHeldPeriod = Milliseconds(5);
constexpr Duration kBacktraceTimeout = Milliseconds(4000);  // before a hung process is killed

}  // namespace

ControllerShell::ControllerShell(Dependencies dependencies, const MachineConfig& config,
                                 Hooks hooks)
    : dependencies_(std::move(dependencies)),
      config_(config),
      hooks_(std::move(hooks)),
      machine_(MakeMachine(config)),
      recorder_(*dependencies_.journal, config),
      peers_(config.actuators.size()) {
  for (const ActuatorIndex i : config.actuators.Indices()) index_[config.actuators[i].name] = i;
}

ControllerShell::~ControllerShell() {
  dependencies_.node->SetOnPeerFault({});
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
  node.SetOnPeerFault([this](const transport::PeerFault& fault) { RecordPeerFault(fault); });
  for (const ActuatorIndex i : peers_.Indices()) {
    auto link = MakeLink(
        node, config_, i, [this](const Event& event) { OnLinkEvent(event); }, dependencies_.links);
    if (!link) return link.error();
    peers_[i].link = std::move(link).value();
    peers_[i].link->OnMachine({config_.name, dependencies_.machine_id});
  }
  auto presence = ControllerPresence::Make(
      node, config_,
      {dependencies_.incarnation, dependencies_.pid, dependencies_.host, dependencies_.host_name,
       dependencies_.machine_id},
      [this](const Event& event) { Handle(event); },
      [this](const ControllerPresence::Rival* other) { OnOtherMachine(other); });
  if (!presence) return presence.error();
  presence_ = std::move(presence).value();
  auto health = HealthWatch::Make(
      node, config_, *dependencies_.process_probe, dependencies_.host,
      [this](const Event& event) { Handle(event); },
      [this](ActuatorIndex i) {
        LinkTo(i).Query({machine_.epoch, 0, false});  // this query fences nothing
      },
      [this](ActuatorIndex i, Incarnation incarnation) { OnAlive(i, incarnation); });
  if (!health) return health.error();
  health_ = std::move(health).value();
  auto inputs = PolicyInputs::Make(node, config_, [this](const Event& event) { Handle(event); });
  if (!inputs) return inputs.error();
  policy_inputs_ = std::move(inputs).value();
  transport::Qos status_qos = transport::kLatchedFromManyQos;
  status_qos.partition = transport::ReaderPartition(!config_.keys.empty());
  auto subscription = transport::MakeSubscription<msg::ActuatorStatus>(
      node, transport::ActuatorStatusTopic(config_.name_space),
      [this](const msg::ActuatorStatus& s, const transport::SampleInfo& i) { OnStatus(s, i); },
      status_qos, {[this](transport::EndpointId writer) { OnWriterLost(writer); }, nullptr});
  if (!subscription) return subscription.error();
  actuator_status_ = std::move(subscription).value();
  return Ok();
}

void ControllerShell::Begin(event::Begin begin, const std::vector<ChildProcess>& children) {
  if (const auto opened = OpenToClients(); !opened) return Refuse(opened.error());
  recorder_.Begin(dependencies_.wall_ns(), dependencies_.config_text);
  begin.host = dependencies_.host;
  begin.stops = Merge(begin.stops, std::exchange(stops_before_begin_, {}));
  // Actuators of another host are only known by their status.
  begin.running.resize(peers_.size());
  for (const auto& [actuator, seen] : before_begin_) {
    if (RanBeforeBegin(actuator)) begin.running[actuator] = true;
  }
  for (const ActuatorIndex i : begin.processes.Indices()) {
    const pid_t pid = begin.processes[i];
    const auto child = std::find_if(children.begin(), children.end(), [&](const ChildProcess& c) {
      return c.pid == pid && c.actuator == config_.actuators[i].name;
    });
    const bool is_child = child != children.end();
    if (WatchFound(i, pid, is_child ? &*child : nullptr)) continue;
    begin.processes[i] = 0;
    const bool exited =
        is_child && dependencies_.process_probe->StartTimeOf(pid) != child->start_time;
    if (exited && !RanBeforeBegin(i)) begin.running[i] = false;
  }
  Handle(begin);
  for (const auto& [actuator, all] : std::exchange(before_begin_, {})) {
    for (const event::StatusSeen& seen : all) {
      Handle(seen);
      const ActuatorReport& taken = machine_.actuators[actuator].report;
      if (taken.incarnation == seen.report.incarnation) {
        health_->OnReport(actuator, taken, SenderOf(actuator, taken));
      }
    }
  }
  if (policy_inputs_) policy_inputs_->Begin();
  if (journal_at_begin_) OnJournalWritten(*journal_at_begin_);
  if (const auto after = std::exchange(tear_down_at_begin_, std::nullopt)) TearDown(*after);
}

// Whether another actuator runs in the process of `report`. That process does not exit, even if
// this actuator is torn down, and a second one would start the other actuator twice.
bool ControllerShell::SharesItsProcess(const ActuatorReport& report) const {
  const auto is_it = [&](const event::StatusSeen& other) {
    const ActuatorReport& running = other.report;
    return running.pid != 0 && running.pid == report.pid && running.host == report.host &&
           Runs(config_, running);
  };
  return std::any_of(before_begin_.begin(), before_begin_.end(),
                     [&](const auto& others) { return std::ranges::any_of(others.second, is_it); });
}

// Whether a process of the actuator, on any host, has reported before Begin() that it runs.
bool ControllerShell::RanBeforeBegin(ActuatorIndex actuator) const {
  const auto found = before_begin_.find(actuator);
  return found != before_begin_.end() &&
         std::ranges::any_of(found->second, [this](const event::StatusSeen& seen) {
           return Runs(config_, seen.report) || SharesItsProcess(seen.report);
         });
}

void ControllerShell::CheckThread() const {
  dependencies_.node->loop().CheckThread();
}

void ControllerShell::Refuse(const Error& why) {
  refused_ = why;
  CloseToClients(why);
  if (hooks_.on_fenced) hooks_.on_fenced(why.message);
}

void ControllerShell::ReleaseControl(const std::string& rival) {
  if (machine_.phase == Phase::kIdle) {
    return Refuse(
        {kCodePermissionDenied, "another controller, " + rival + ", takes the machine over"});
  }
  Handle(event::RivalSeen{machine_.epoch + 1, rival, true});
}

void ControllerShell::SetState(const State& target, const std::optional<std::string>& actuator,
                               OnResult done, const Requester& by) {
  CheckThread();
  if (refused_) return done(Refusal(*refused_));
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
  const RequestId request = next_request_++;
  waiting_for_answer_[request] = std::move(done);
  Handle(event::SetUpAwaited{request});
}

void ControllerShell::Restart(const std::string& actuator, OnAnswer done) {
  CheckThread();
  if (refused_) return done(*refused_);
  const RequestId request = next_request_++;
  waiting_for_answer_[request] = std::move(done);
  Handle(event::RestartRequested{request, actuator});
}

void ControllerShell::ReleaseEmergencyStop(const std::string& by, OnAnswer done) {
  CheckThread();
  if (refused_) return done(*refused_);
  const RequestId request = next_request_++;
  waiting_for_answer_[request] = std::move(done);
  Handle(event::ReleaseRequested{request, by});
}

void ControllerShell::SendPolicyRequest(event::PolicyRequested requested, OnAnswer done) {
  CheckThread();
  if (refused_) return done(*refused_);
  requested.request = next_request_++;
  waiting_for_answer_[requested.request] = std::move(done);
  Handle(requested);
}

void ControllerShell::Remark(std::int32_t code, const std::string& message) {
  CheckThread();
  RecordHere("machine", std::nullopt, code, {EventName::kControllerRemark, message});
}

void ControllerShell::RecordHere(const std::string& kind, std::optional<ActuatorIndex> actuator,
                                 std::int32_t code, const RecordText& text) {
  action::Record record{kind, actuator, 0, code, text.message};
  record.event = text.event;
  record.arguments = text.arguments;
  Do(record);
}

// Handles events one after the other: a callback that gets an answer may send a new request.
void ControllerShell::Handle(const Event& event) {
  CheckThread();
  if (KeepForBegin(event)) return;
  // Every event may begin a time of the policy: the end of a switch that of lying still.
  if (policy_inputs_ && !handling_) policy_inputs_->EmitTime();
  queue_.push_back(event);
  if (handling_) return;
  handling_ = true;
  HandleQueued();
  handling_ = false;
  ArmTimer();
  PublishSoon();
  PublishWhileUnsaved();
  if (capabilities_) capabilities_->Refresh();
}

void ControllerShell::HandleQueued() {
  while (!queue_.empty()) {
    const Event event = std::move(queue_.front());
    queue_.pop_front();
    const Time now = dependencies_.node->loop().Now();
    recorder_.Note(dependencies_.wall_ns(), machine_, event, now);
    const std::vector<Action> actions = Step(config_, machine_, event, now);
    for (const Action& action : actions) {
      std::visit([this](const auto& a) { Do(a); }, action);
    }
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

// The link to the process whose report is current; the previous process may still be matched.
ActuatorLink& ControllerShell::LinkTo(ActuatorIndex actuator) {
  Peer& peer = peers_[actuator];
  for (const Process& process : peer.processes) {
    if (process.participant != 0 && process.Is(machine_.actuators[actuator].report)) {
      peer.link->OnPeer(process.participant);
    }
  }
  return *peer.link;
}

void ControllerShell::SetMachineId(const std::string& id) {
  presence_->SetMachineId(id);
  for (Peer& peer : peers_) peer.link->OnMachine(machine_identity());
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
    RecordHere(
        "machine", std::nullopt, kCodeParametersInvalid,
        texts::OtherMachineSeen(MachineText(other->machine), other->process, config_.name_space));
  }
  PublishSoon();
}

void ControllerShell::Do(const action::SendSwitch& a) {
  if (hooks_.on_send) hooks_.on_send(a);
  LinkTo(a.actuator).Switch(a.command);
}

void ControllerShell::Do(const action::SendQuery& a) {
  // A new actuator obeys only a controller whose heartbeat it has received.
  if (machine_.actuators[a.actuator].presence != Presence::kPresent) presence_->Repeat();
  LinkTo(a.actuator).Query(a.command);
}

void ControllerShell::Do(const action::AnswerSetState& a) {
  const auto waiting = waiting_for_result_.extract(a.request);
  if (!waiting.empty() && waiting.mapped()) waiting.mapped()(a.result);
}

void ControllerShell::Do(const action::AnswerCall& a) {
  const auto waiting = waiting_for_answer_.extract(a.request);
  if (!waiting.empty()) waiting.mapped()(a.result);
}

void ControllerShell::Do(const action::TakeBacktrace& a) {
  const bool own = config_.actuators[a.actuator].protocol == Protocol::kMusher;
  const pid_t traced = own ? a.pid : dependencies_.process_probe->WorkerOf(a.pid);
  dependencies_.process_probe->TakeBacktrace(
      traced, kBacktraceTimeout, [this, a](Result<std::string> stacks) {
        Handle(event::BacktraceTaken{
            a.actuator, a.pid,
            stacks ? stacks.value() : "no backtrace: " + stacks.error().message});
      });
}

void ControllerShell::Do(const action::PublishEmergencyStop& a) {
  presence_->Publish(a.stop, a.engaged);
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

void ControllerShell::Do(const action::Fenced& a) {
  starts_later_.clear();
  presence_->FallSilent();
  CloseToClients({kCodePermissionDenied, a.message});
  if (hooks_.on_fenced) hooks_.on_fenced(a.message);
}

void ControllerShell::Do(const action::Record& a) {
  JournalEntry entry;
  entry.wall_ns = dependencies_.wall_ns();
  entry.steady_ns = transport::ToNanoseconds(dependencies_.node->loop().Now());
  entry.epoch = machine_.epoch;
  entry.switch_number = a.switch_number;
  entry.kind = a.kind;
  if (a.actuator) entry.actuator = config_.actuators[*a.actuator].name;
  entry.code = a.code;
  entry.message = a.message;
  entry.data = DataOf(a);
  entry.id = a.id;
  entry.cause = a.cause;
  entry.state = a.state;
  entry.event = NameOf(a.event);
  if (a.of_switch) {
    if (switches_.size() == kSwitchEntriesKept) switches_.erase(switches_.begin());
    switches_.push_back(entry);
  }
  dependencies_.journal->Append(std::move(entry));
  if (hooks_.on_record) hooks_.on_record(a);
}

void ControllerShell::Do(const action::StartUpEnded& a) {
  if (hooks_.on_start_up_ended) hooks_.on_start_up_ended(a);
}

// The cause may be a request that is still being handled: its service closes after its reply.
void ControllerShell::Do(const action::Stopped&) {
  PublishStatus();
  presence_->FallSilent();
  CloseOnceAnswered(dependencies_.node->loop().Now() + kLastAnswers);
  if (hooks_.on_stopped) hooks_.on_stopped();
}

void ControllerShell::CloseOnceAnswered(Time deadline) {
  const Time now = dependencies_.node->loop().Now();
  const bool holds = hooks_.holds_answers && hooks_.holds_answers() && now < deadline;
  const auto next = [this, deadline, holds] {
    if (holds) return CloseOnceAnswered(deadline);
    CloseToClients({kCodeStateInvalid, "the machine is stopped; only a new start brings it back"});
  };
  close_later_ = dependencies_.node->loop().At(holds ? now + kHeldPeriod : now, next);
}

}  // namespace musher
