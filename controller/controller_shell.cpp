#include "musher/controller/controller_shell.hpp"

#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "musher/transport/lifecycle_wire.hpp"

namespace musher {
namespace {

// Long past every deadline of the decision code, which does its own waiting: ends a forgotten call.
constexpr Duration kCallTimeout = std::chrono::hours(2);
constexpr Duration kPublishPeriod = Milliseconds(20);

}  // namespace

ControllerShell::ControllerShell(World world, const MachineConfig& config, Hooks hooks)
    : world_(std::move(world)),
      config_(config),
      hooks_(std::move(hooks)),
      machine_(MakeMachine(config)),
      recorder_(*world_.journal, config),
      links_(config.actuators.size()) {
  for (std::size_t i = 0; i < config.actuators.size(); ++i) index_[config.actuators[i].name] = i;
}

ControllerShell::~ControllerShell() = default;

Result<std::unique_ptr<ControllerShell>> ControllerShell::Make(World world,
                                                               const MachineConfig& config,
                                                               Hooks hooks) {
  std::unique_ptr<ControllerShell> shell(
      new ControllerShell(std::move(world), config, std::move(hooks)));
  if (auto opened = shell->Open(); !opened) return opened.error();
  return shell;
}

Result<> ControllerShell::Open() {
  transport::Node& node = *world_.node;
  auto status = transport::MakePublisher<msg::MachineStatus>(
      node, transport::MachineStatusTopic(config_.name_space), transport::kLatchedQos);
  if (!status) return status.error();
  status_ = std::move(status).value();
  auto info = transport::MakePublisher<msg::MachineInfo>(
      node, std::string(transport::kMachinesTopic), transport::kLatchedQos);
  if (!info) return info.error();
  info_ = std::move(info).value();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    auto client = transport::MakeClient<msg::ActuatorCommand>(
        node, transport::CommandService(config_.name_space, config_.actuators[i].name));
    if (!client) return client.error();
    links_[i].client = std::move(client).value();
  }
  auto subscription = transport::MakeSubscription<msg::ActuatorStatus>(
      node, transport::ActuatorStatusTopic(config_.name_space),
      [this](const msg::ActuatorStatus& s, const transport::SampleInfo& i) { OnStatus(s, i); },
      transport::kLatchedFromManyQos,
      {[this](transport::PeerId writer) { OnWriterLost(writer); }, nullptr});
  if (!subscription) return subscription.error();
  actuator_status_ = std::move(subscription).value();
  return info_->Publish({config_.name, config_.name_space, world_.host, world_.pid});
}

void ControllerShell::Begin(bool by_hand, std::uint64_t epoch, std::vector<bool> running) {
  recorder_.Begin(world_.wall_ns(), world_.config_text);
  Handle(event::Begin{by_hand, epoch, std::move(running)});
}

void ControllerShell::SetState(const State& target, const std::optional<std::string>& actuator,
                               OnResult done) {
  const RequestId request = next_request_++;
  waiting_for_result_[request] = std::move(done);
  Handle(event::SetStateRequested{request, target, actuator});
}

void ControllerShell::AwaitSetUp(OnSetUp done) {
  if (machine_.set_up) return done(Ok());
  const RequestId request = next_request_++;
  waiting_for_set_up_[request] = std::move(done);
  Handle(event::SetUpAwaited{request});
}

void ControllerShell::OnStatus(const msg::ActuatorStatus& status,
                               const transport::SampleInfo& info) {
  const auto found = index_.find(status.name);
  if (found == index_.end()) return;  // an actuator of another machine of this namespace
  const std::size_t i = found->second;
  const ActuatorReport report = transport::FromMessage(status);
  speakers_[info.writer] = {i, report.incarnation};
  WatchForeign(i, report);
  CompareHash(i, status.config_hash);
  Handle(event::StatusSeen{i, report});
}

void ControllerShell::OnWriterLost(transport::PeerId writer) {
  const auto speaker = speakers_.extract(writer);
  if (speaker.empty()) return;
  const auto [actuator, incarnation] = speaker.mapped();
  Handle(event::Vanished{actuator, incarnation, false, "it is out of reach"});
}

// A process of this host that we did not start: its end is seen as fast as a child's, only the exit
// code is not.
void ControllerShell::WatchForeign(std::size_t actuator, const ActuatorReport& report) {
  Link& link = links_[actuator];
  if (link.watched == report.incarnation) return;
  link.watched = report.incarnation;
  if (report.host != world_.host || report.host.empty() ||
      report.pid == machine_.actuators[actuator].process || report.pid == world_.pid) {
    return;
  }
  const auto watched = world_.processes->Watch(
      report.pid,
      [this, actuator, incarnation = report.incarnation, pid = report.pid](const ProcessExit&) {
        Handle(event::Vanished{actuator, incarnation, true,
                               "its process " + std::to_string(pid) + " ended"});
      });
  // Failing means that it ended already; then its writer goes as well.
  static_cast<void>(watched.ok());
}

void ControllerShell::CompareHash(std::size_t actuator, const std::string& hash) {
  Link& link = links_[actuator];
  if (hash == config_.hash || link.hash_told) return;
  link.hash_told = true;
  Do(action::Record{"actuator", actuator, 0, kCodeParametersInvalid,
                    config_.actuators[actuator].name + " has read another config (" + hash +
                        ") than " + config_.file + " (" + config_.hash + ")"});
}

void ControllerShell::OnReply(std::size_t actuator, std::uint64_t number, bool ask,
                              const Result<msg::ActuatorCommand::Response>& reply) {
  if (!reply) return;  // the decision code has its own deadline for it
  const msg::ActuatorCommand::Response& response = reply.value();
  if (response.status.name != config_.actuators[actuator].name) return;
  Handle(event::Replied{actuator, number, ask, transport::VerdictFrom(response.verdict),
                        response.code, response.message, transport::FromMessage(response.status)});
}

// Events are handled one after the other: an answer given to somebody may come back as a request.
void ControllerShell::Handle(const Event& event) {
  queue_.push_back(event);
  if (handling_) return;
  handling_ = true;
  HandleQueued();
  handling_ = false;
  ArmTimer();
  PublishSoon();
}

void ControllerShell::HandleQueued() {
  while (!queue_.empty()) {
    const Event event = std::move(queue_.front());
    queue_.pop_front();
    const Time now = world_.node->loop().Now();
    recorder_.Note(world_.wall_ns(), machine_, event, now);
    const std::vector<Action> actions = Step(config_, machine_, event, now);
    for (const Action& action : actions) {
      std::visit([this](const auto& a) { Do(a); }, action);
    }
  }
}

void ControllerShell::ArmTimer() {
  const std::optional<Time> next = NextDeadline(config_, machine_);
  if (next == armed_for_) return;
  armed_for_ = next;
  timer_ = nullptr;
  if (!next) return;
  timer_ = world_.node->loop().At(*next, [this] {
    armed_for_.reset();
    Handle(event::TimePassed{});
  });
}

// The status is latched for people and dashboards: what changes within a moment is told as one.
void ControllerShell::PublishSoon() {
  if (publish_later_) return;
  const Time now = world_.node->loop().Now();
  publish_later_ = world_.node->loop().At(std::max(now, published_at_ + kPublishPeriod), [this] {
    publish_later_ = nullptr;
    Publish();
  });
}

void ControllerShell::Publish() {
  msg::MachineStatus status = Status();
  if (status == published_) return;
  static_cast<void>(
      status_->Publish(status));  // a latch that fails is told again at the next change
  published_ = std::move(status);
  published_at_ = world_.node->loop().Now();
}

void ControllerShell::Send(std::size_t actuator, msg::ActuatorCommand::Request request) {
  const ActuatorRecord& record = machine_.actuators[actuator];
  const bool ask = request.kind == msg::ActuatorCommand::kKindAsk;
  request.epoch = machine_.epoch;
  request.incarnation = record.report.incarnation;
  request.status_stamp_ns = transport::ToNanoseconds(record.clock_theirs);
  request.since_status_ns = Duration(world_.node->loop().Now() - record.clock_ours).count();
  links_[actuator].client->Call(request, kCallTimeout,
                                [this, actuator, number = request.number,
                                 ask](const Result<msg::ActuatorCommand::Response>& reply) {
                                  OnReply(actuator, number, ask, reply);
                                });
}

void ControllerShell::Do(const action::SendSwitch& a) {
  msg::ActuatorCommand::Request request;
  request.kind = msg::ActuatorCommand::kKindSwitch;
  request.number = a.number;
  request.target = a.target;
  request.budget_ns = a.budget.count();
  Send(a.actuator, std::move(request));
}

void ControllerShell::Do(const action::SendAsk& a) {
  msg::ActuatorCommand::Request request;
  request.kind = msg::ActuatorCommand::kKindAsk;
  request.number = a.number;
  request.stop = a.stop;
  Send(a.actuator, std::move(request));
}

void ControllerShell::Do(const action::StartProcess& a) {
  const ActuatorConfig& actuator = config_.actuators[a.actuator];
  ProcessSpec spec;
  spec.name = actuator.name;
  spec.argv = actuator.command;
  spec.cwd = actuator.cwd;
  spec.env = actuator.env;
  if (!config_.file.empty()) {
    spec.env.emplace("MUSHER_CONFIG", std::filesystem::absolute(config_.file).string());
  }
  spec.env.emplace("MUSHER_ACTUATOR", actuator.name);
  spec.log_file = world_.log_file(actuator.name);
  auto pid = std::make_shared<pid_t>(0);
  const auto started =
      world_.processes->Start(spec, [this, i = a.actuator, pid](const ProcessExit& exit) {
        Handle(event::ProcessEnded{i, *pid, exit.clean(), exit.Text()});
      });
  if (!started) return Handle(event::ProcessNotStarted{a.actuator, started.error().message});
  *pid = started.value();
  Handle(event::ProcessStarted{a.actuator, started.value()});
}

void ControllerShell::Do(const action::SignalProcess& a) {
  // One that ended meanwhile needs no signal.
  static_cast<void>(world_.processes->Signal(a.pid, a.kill ? SIGKILL : SIGTERM).ok());
}

void ControllerShell::Do(const action::AnswerSetState& a) {
  const auto waiting = waiting_for_result_.extract(a.request);
  if (!waiting.empty() && waiting.mapped()) waiting.mapped()(a.result);
}

void ControllerShell::Do(const action::AnswerSetUp& a) {
  const auto waiting = waiting_for_set_up_.extract(a.request);
  if (!waiting.empty()) waiting.mapped()(a.result);
}

void ControllerShell::Do(const action::SaveEpoch& a) {
  world_.save_epoch(a.epoch);
}

void ControllerShell::Do(const action::Record& a) {
  JournalEntry entry;
  entry.wall_ns = world_.wall_ns();
  entry.steady_ns = transport::ToNanoseconds(world_.node->loop().Now());
  entry.epoch = machine_.epoch;
  entry.switch_number = a.switch_number;
  entry.kind = a.kind;
  if (a.actuator) entry.actuator = config_.actuators[*a.actuator].name;
  entry.code = a.code;
  entry.message = a.message;
  entry.id = a.id;
  entry.cause = a.cause;
  entry.state = a.state;
  world_.journal->Append(std::move(entry));
  if (hooks_.on_record) hooks_.on_record(a);
}

void ControllerShell::Do(const action::StartUpEnded& a) {
  if (hooks_.on_start_up_ended) hooks_.on_start_up_ended(a);
}

void ControllerShell::Do(const action::Stopped&) {
  Publish();
  if (hooks_.on_stopped) hooks_.on_stopped();
}

msg::MachineStatus ControllerShell::Status() const {
  msg::MachineStatus status;
  status.machine = config_.name;
  status.name_space = config_.name_space;
  status.phase = PhaseName(machine_.phase);
  status.state = machine_.state;
  status.epoch = machine_.epoch;
  if (machine_.current) status.target = machine_.current->target;
  status.switch_number = machine_.last_switch;
  status.pid = world_.pid;
  status.host = world_.host;
  status.config_file = config_.file;
  status.config_hash = config_.hash;
  status.degraded = Degraded(config_, machine_);
  for (std::size_t i = 0; i < config_.actuators.size(); ++i) {
    const ActuatorRecord& record = machine_.actuators[i];
    msg::ActuatorInfo info;
    info.name = config_.actuators[i].name;
    info.state = record.state();
    info.target = record.order ? record.order->target : record.report.target;
    info.presence = PresenceName(record.presence);
    info.pid = record.process != 0 ? record.process
               : record.presence == Presence::kPresent || record.presence == Presence::kStarting
                   ? record.report.pid
                   : 0;
    info.host = record.report.host;
    info.stage = config_.actuators[i].stage;
    info.critical = config_.actuators[i].critical;
    info.held = record.held;
    info.degraded = record.fault.has_value();
    if (record.fault) {
      info.code = record.fault->code;
      info.message = record.fault->message;
    }
    status.actuators.push_back(std::move(info));
  }
  return status;
}

}  // namespace musher
