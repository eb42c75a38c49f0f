#include "musher/actuator/actuator_shell.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/health/health_monitor.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

// Names of states and actuators are shorter than this; a longer one is not valid.
constexpr std::size_t kLongestName = 256;
// The latched status may lag by this time: every reply carries the status too, so a short callback
// need not be published twice, and a switch does not wait for the publication.
constexpr Duration kStatusDelay = Milliseconds(50);
// The endpoints of a managed node are offered after those that a controller needs: after the first
// time without a controller, after the second with one, when the start of the robot is over.
constexpr Duration kControllerDetected = Milliseconds(150);
constexpr Duration kStartIsOver = Milliseconds(2000);
// A ROS 2 manager queries the state once more after its shutdown.
constexpr Duration kLastQueryTime = Milliseconds(1000);
constexpr Duration kLastQueryPeriod = Milliseconds(5);
// So many heartbeats of its controller in a row have not arrived: it is lost.
constexpr int kMissedHeartbeats = 3;

// Samples our own process; a simulated process has no sample.
Checkpoints::Sample SampleOf(pid_t pid) {
  return [pid](Time now) -> std::optional<ProcessSample> {
    if (pid != getpid()) return std::nullopt;
    return SampleProcess(pid, now);
  };
}

SwitchCommand SwitchFrom(const msg::ActuatorCommand::Request& request) {
  SwitchCommand command;
  command.epoch = Epoch(request.epoch);
  command.number = CommandNumber(request.number);
  command.target = State(request.target.substr(0, kLongestName));
  command.budget = Duration(request.budget_ns);
  command.status_stamp = transport::FromNanoseconds(request.status_stamp_ns);
  command.since_status = Duration(request.since_status_ns);
  command.incarnation = Incarnation(request.incarnation);
  command.detached = request.detached;
  return command;
}

}  // namespace

ActuatorShell::ActuatorShell(transport::Node& node, Worker& worker, const MachineConfig& config,
                             ActuatorIndex index, ActuatorIdentity identity, Hooks hooks)
    : node_(node),
      worker_(worker),
      config_(config),
      index_(index),
      actuator_(config.actuators[index]),
      hooks_(std::move(hooks)),
      checkpoints_(actuator_, SampleOf(identity.pid)) {
  core_.report.state = config.default_state;
  core_.report.incarnation = identity.incarnation;
  core_.report.pid = identity.pid;
  core_.report.host = std::move(identity.host);
  core_.report.config_hash = config.hash;
  machine_ = {identity.machine.empty() ? config.name : identity.machine,
              std::move(identity.machine_id)};
}

Result<std::unique_ptr<ActuatorShell>> ActuatorShell::Make(transport::Node& node, Worker& worker,
                                                           const MachineConfig& config,
                                                           ActuatorIndex index,
                                                           ActuatorIdentity identity, Hooks hooks) {
  std::unique_ptr<ActuatorShell> shell(
      new ActuatorShell(node, worker, config, index, std::move(identity), std::move(hooks)));
  if (auto opened = shell->Open(); !opened) return opened.error();
  return shell;
}

Result<> ActuatorShell::Open() {
  const std::string& name_space = config_.name_space;
  transport::Qos status_qos = transport::kLatchedQos;
  transport::Qos heartbeat_qos = transport::kHeartbeatQos;
  status_qos.partition = heartbeat_qos.partition = transport::WriterPartition(config_, index_);
  auto status = transport::MakePublisher<msg::ActuatorStatus>(
      node_, transport::ActuatorStatusTopic(name_space), status_qos);
  if (!status) return status.error();
  status_ = std::move(status).value();
  auto heartbeats = transport::MakePublisher<msg::ActuatorHeartbeat>(
      node_, transport::ActuatorHeartbeatTopic(name_space), heartbeat_qos);
  if (!heartbeats) return heartbeats.error();
  heartbeats_ = std::move(heartbeats).value();
  auto controllers = transport::MakeSubscription<msg::ControllerHeartbeat>(
      node_, transport::ControllerHeartbeatTopic(name_space),
      [this](const msg::ControllerHeartbeat& heartbeat, const transport::SampleInfo& info) {
        OnControllerHeartbeat(heartbeat, info);
      },
      transport::kLatchedFromManyQos);
  if (!controllers) return controllers.error();
  controllers_ = std::move(controllers).value();
  auto stops = transport::SubscribeToStops(
      node_, name_space, [this](const msg::EmergencyStop& stop, const transport::SampleInfo& info) {
        OnEmergencyStop(stop, info);
      });
  if (!stops) return stops.error();
  emergency_stops_ = std::move(stops).value();
  if (auto watched = WatchPermits(); !watched) return watched.error();
  return WatchBattery();
}

// A permit names its machine. A permit for another robot, or for any, permits nothing.
Result<> ActuatorShell::WatchPermits() {
  if (!config_.permit) return Ok();
  auto permits = transport::MakeSubscription<msg::Permit>(
      node_, transport::PermitTopic(config_.name_space),
      [this](const msg::Permit& permit, const transport::SampleInfo& info) {
        if (permit.machine.empty() || !transport::IsOwn(permit.participant, info)) return;
        if (!SameMachine(machine_, {permit.machine, permit.machine_id})) return;
        Handle(actuator_event::PermitReceived{Sender(info.participant.value()),
                                              transport::FromNanoseconds(permit.stamp_ns),
                                              permit.by});
      },
      transport::kHeartbeatQos);
  if (!permits) return permits.error();
  permits_ = std::move(permits).value();
  return Ok();
}

Result<> ActuatorShell::WatchBattery() {
  const auto& all = config_.capabilities;
  const bool needed = std::any_of(all.begin(), all.end(), [this](const CapabilityConfig& c) {
    return c.min_battery && c.Takes(actuator_.name);
  });
  if (!needed || !hooks_.on_battery) return Ok();
  auto watch = transport::BatteryWatch::Make(node_, config_, hooks_.on_battery);
  if (!watch) return watch.error();
  battery_ = std::move(watch).value();
  return Ok();
}

void ActuatorShell::OnControllerHeartbeat(const msg::ControllerHeartbeat& heartbeat,
                                          const transport::SampleInfo& info) {
  if (!transport::IsOwn(heartbeat.participant, info)) return;
  const MachineIdentity theirs{heartbeat.machine, heartbeat.machine_id};
  if (!SameMachine(machine_, theirs)) {
    // A controller on the host of this actuator belongs to its machine: its config may be another
    // one, and its id is a new one where its state folder was lost.
    const bool here = !heartbeat.host.empty() && heartbeat.host == core_.report.host;
    if (!here || !hooks_.leads_here || !hooks_.leads_here(heartbeat.pid)) return;
    machine_ = theirs;
    Publish();  // the controller that it has followed learns of it before it commands
  }
  Handle(actuator_event::ControllerHeartbeatReceived{Sender(info.participant.value()),
                                                     Epoch(heartbeat.epoch)});
  if (Sender(info.participant.value()) == core_.controller) controller_heard_ = node_.loop().Now();
}

// A stop without an identity stops every machine that receives it.
void ActuatorShell::OnEmergencyStop(const msg::EmergencyStop& stop,
                                    const transport::SampleInfo& info) {
  if (!SameMachine(machine_, {stop.machine, stop.machine_id})) return;
  Handle(actuator_event::EmergencyStopReceived{StopId(stop.id), stop.engaged,
                                               Sender(info.participant.value()), stop.by,
                                               stop.reason, CommandNumber(stop.last_command)});
}

void ActuatorShell::Start() {
  Handle(actuator_event::Started{});
  CheckWork();
}

void ActuatorShell::OnRequest(const msg::ActuatorCommand::Request& request, Reply reply,
                              transport::ParticipantId sender) {
  const RequestToken token = next_token_++;
  replies_[token] = [this, reply = std::move(reply)](const actuator_action::Answer& answer) {
    reply({transport::ToMessage(answer.verdict), answer.code, answer.message, Status()});
  };
  const MachineIdentity theirs{request.machine, request.machine_id};
  if (!SameMachine(machine_, theirs)) {
    return Refuse(token, Refused<Refusal::kOtherMachine>(
                             MachineText(theirs).substr(0, kLongestName), MachineText(machine_)));
  }
  const Sender from(sender.value());
  switch (request.kind) {
    case msg::ActuatorCommand::kKindSwitch:
      Handle(actuator_event::SwitchArrived{token, SwitchFrom(request), from});
      break;
    case msg::ActuatorCommand::kKindQuery:
      Handle(actuator_event::QueryArrived{
          token, {Epoch(request.epoch), CommandNumber(request.number), request.stop}, from});
      break;
    default:
      return Refuse(token, Refused<Refusal::kUnknownKind>(request.kind));
  }
  if (machine_.id.empty() && from != 0 && core_.controller == from) machine_.id = theirs.id;
}

std::optional<Error> ActuatorShell::MayBeLate(const State& target, transport::LoopBreaks& breaks) {
  const auto could_not_run = breaks.Recent();
  const State& from = core_.report.state;
  const bool raises = Rises(config_, from, target) || SwitchesOnAgain(config_, from, target);
  if (!could_not_run || !raises) return std::nullopt;
  return Refused<Refusal::kActuatorMayBeLate>(actuator_.name,
                                              ToMilliseconds(*could_not_run) / 1000);
}

void ActuatorShell::OnManager(const State& target, transport::LoopBreaks& breaks,
                              OnManagerAnswered answered) {
  const RequestToken token = next_token_++;
  replies_[token] = std::move(answered);
  if (const auto late = MayBeLate(target, breaks)) return Refuse(token, *late);
  Handle(actuator_event::ManagerCommand{token, State(target.name().substr(0, kLongestName))});
}

void ActuatorShell::OfferToRos2At(Time when) {
  offer_later_ = node_.loop().At(when, [this] { OfferToRos2(); });
}

void ActuatorShell::OfferToRos2() {
  offer_later_ = nullptr;
  if (hooks_.ros2 == Hooks::Ros2::kManagedNode) return OfferManagedNode();
  services_.emplace(node_, transport::ResolveName(config_.name_space, actuator_.name),
                    transport::ParametersOf(config_));
}

void ActuatorShell::OfferManagedNode() {
  transport::ManagedNodeEndpoints::Hooks hooks;
  hooks.refusal = [this](const Ros2Transition*, transport::ParticipantId) -> std::optional<Error> {
    if (core_.report.epoch == 0) return std::nullopt;
    // It may have exited: the next controller continues, and this actuator waits for it.
    return Refused<Refusal::kUnderControl>(core_.report.epoch,
                                           transport::ResolveName(config_.name_space, "musher"));
  };
  hooks.change = [this](const Ros2Transition& transition, transport::ParticipantId, auto done) {
    ChangeManagedNode(transition, std::move(done));
  };
  hooks.log = hooks_.on_remark;
  hooks.parameters = transport::ParametersOf(config_);
  managed_node_breaks_.emplace(node_.loop());
  const std::string instance = actuator_.name + "-" + ToString(core_.report.incarnation);
  auto made = transport::ManagedNodeEndpoints::Make(node_, config_.name_space, actuator_.name,
                                                    instance, std::move(hooks));
  if (!made) {  // a controller can still drive it
    if (hooks_.on_remark) hooks_.on_remark("no ROS 2 managed node: " + made.error().message);
    return;
  }
  managed_node_ = std::move(made).value();
  managed_node_->Observe(core_.report.state, core_.report.target);
}

void ActuatorShell::ChangeManagedNode(const Ros2Transition& transition,
                                      transport::ManagedNodeEndpoints::Done done) {
  const auto target = TargetOf(transition, actuator_, config_);
  if (!target) {
    return done(Refused<Refusal::kNoStateForTransition>(actuator_.name));
  }
  if (target->empty()) return done(Ok());
  OnManager(
      *target, *managed_node_breaks_,
      [done = std::move(done)](const actuator_action::Answer& answer) {
        if (answer.verdict == Verdict::kDone) return done(Ok());
        done(Error{answer.code, answer.message.empty() ? "its callback failed" : answer.message});
      });
}

void ActuatorShell::Handle(const ActuatorEvent& event) {
  node_.loop().CheckThread();
  if (closed_ && !CountsWhenClosed(event)) return;
  const std::vector<ActuatorAction> actions =
      Step(config_, index_, core_, event, node_.loop().Now());
  if (hooks_.on_report) hooks_.on_report(core_.report);  // before any reply is sent
  if (managed_node_) managed_node_->Observe(core_.report.state, core_.report.target);
  for (const ActuatorAction& action : actions) {
    std::visit([this](const auto& a) { Do(a); }, action);
  }
  ArmTimer();
}

// A callback that still runs may move: a stop stops it, and so does a permit that ends; again when
// the callback has ended. Nothing of this begins one.
bool ActuatorShell::CountsWhenClosed(const ActuatorEvent& event) {
  const bool ended = std::holds_alternative<actuator_event::CallbackEnded>(event);
  if (ended && std::exchange(core_.stopped_meanwhile, false)) {
    Do(actuator_action::RunEmergencyStop{});
  }
  if (ended || !core_.report.busy()) return false;
  return std::holds_alternative<actuator_event::EmergencyStopReceived>(event) ||
         std::holds_alternative<actuator_event::PermitReceived>(event) ||
         std::holds_alternative<actuator_event::TimePassed>(event);
}

void ActuatorShell::ArmTimer() {
  const std::optional<Time> next = NextDeadline(config_, index_, core_);
  if (next == armed_for_) return;
  armed_for_ = next;
  timer_ = nullptr;
  if (!next) return;
  timer_ = node_.loop().At(*next, [this] {
    armed_for_.reset();
    Handle(actuator_event::TimePassed{});
  });
}

// Publishes the heartbeat with its period, and at once when the work thread hangs or makes progress
// again.
void ActuatorShell::CheckWork() {
  const Time now = node_.loop().Now();
  const Duration period = HeartbeatPeriod(config_, index_);
  const Checkpoints::Look look = checkpoints_.Evaluate(now);
  if (look.work != sent_work_ || now - heartbeat_at_ >= period) Heartbeat(look);
  const Duration next =
      std::min(checkpoints_.Period().value_or(period), heartbeat_at_ + period - now);
  look_ = node_.loop().At(now + next, [this] { CheckWork(); });
}

// A lost heartbeat is followed by the next.
void ActuatorShell::Heartbeat(const Checkpoints::Look& look) {
  heartbeat_at_ = node_.loop().Now();
  sent_work_ = look.work;
  msg::ActuatorHeartbeat heartbeat;
  heartbeat.name = actuator_.name;
  heartbeat.incarnation = core_.report.incarnation.value();
  heartbeat.period_ns = HeartbeatPeriod(config_, index_).count();
  heartbeat.work = transport::ToMessage(look.work);
  if (look.work != Health::kWell) {
    heartbeat.during = look.during;
    heartbeat.silent_ns = look.silent.count();
    heartbeat.waited_ns = look.waited.count();
  }
  heartbeat.controller_lost =
      heartbeat_at_ - controller_heard_ > kMissedHeartbeats * ControllerHeartbeatPeriod(config_);
  static_cast<void>(heartbeats_->Publish(heartbeat));
}

void ActuatorShell::Do(const actuator_action::RunEmergencyStop&) {
  if (hooks_.on_emergency_stop) hooks_.on_emergency_stop();
  Publish();  // the program that engaged the stop waits for this
}

void ActuatorShell::Do(const actuator_action::RunCallback& action) {
  checkpoints_.Begin(action.target, node_.loop().Now());
  if (checkpoints_.Period()) look_ = node_.loop().At(node_.loop().Now(), [this] { CheckWork(); });
  if (hooks_.set_stop_requested) hooks_.set_stop_requested(false);
  worker_.Run([run = hooks_.run_callback, target = action.target] { return run(target); },
              [this, alive = std::weak_ptr<bool>(alive_), &loop = node_.loop()](Result<> result) {
                loop.Post([this, alive, result = std::move(result)] {
                  if (alive.expired()) return;
                  checkpoints_.End();
                  actuator_event::CallbackEnded ended;
                  if (!result) {
                    ended.code = result.error().code;
                    ended.message = result.error().message;
                  }
                  if (hooks_.take_degraded) {
                    Error degraded = hooks_.take_degraded();
                    ended.degraded_code = degraded.code;
                    ended.degraded_reason = std::move(degraded.message);
                  }
                  Handle(ended);
                });
              });
}

void ActuatorShell::CompareStopTrouble() {
  node_.loop().Post([this, alive = std::weak_ptr<bool>(alive_)] {
    if (!alive.expired() && StopTrouble() != stop_trouble_) Publish();
  });
}

void ActuatorShell::ReportFault(const Error& fault) {
  node_.loop().Post([this, alive = std::weak_ptr<bool>(alive_),
                     event = actuator_event::PartFailed{fault.code, fault.message}] {
    if (!alive.expired()) Handle(event);
  });
}

void ActuatorShell::Do(const actuator_action::RequestStop&) {
  if (hooks_.set_stop_requested) hooks_.set_stop_requested(true);
}

void ActuatorShell::Do(const actuator_action::Answer& action) {
  const auto node = replies_.extract(action.token);
  if (!node.empty()) node.mapped()(action);
}

void ActuatorShell::Do(const actuator_action::PublishStatus&) {
  if (core_.report.epoch == 0) return Publish();  // no controller controls it yet
  if (publish_later_) return;
  publish_later_ = node_.loop().At(node_.loop().Now() + kStatusDelay, [this] { Publish(); });
}

// A failed publish is harmless: every reply carries the status.
void ActuatorShell::Publish() {
  publish_later_ = nullptr;
  const msg::ActuatorStatus status = Status();
  stop_trouble_ = status.stop_trouble;
  static_cast<void>(status_->Publish(status));
}

void ActuatorShell::Do(const actuator_action::BecomeVisible&) {
  auto server = transport::MakeServer<msg::ActuatorCommand>(
      node_, transport::CommandService(config_.name_space, actuator_.name),
      [this](const msg::ActuatorCommand::Request& request, Reply reply,
             transport::ParticipantId sender) { OnRequest(request, std::move(reply), sender); });
  if (!server) return hooks_.on_finished(server.error());
  server_ = std::move(server).value();
  fs_machine_breaks_.emplace(node_.loop());
  auto fs_machine = FsMachine::Make(
      node_, config_.name_space, actuator_.name,
      [this](const State& target, FsMachine::Reply reply) {
        OnManager(target, *fs_machine_breaks_,
                  [this, reply = std::move(reply)](const actuator_action::Answer& answer) {
                    reply(core_.report.state, answer.code);
                  });
      });
  if (!fs_machine) return hooks_.on_finished(fs_machine.error());
  fs_machine_ = std::move(fs_machine).value();
  if (hooks_.ros2 != Hooks::Ros2::kNothing) {
    const Time now = node_.loop().Now();
    offer_later_ = node_.loop().At(now + kControllerDetected, [this, now] {
      if (!core_.announced.empty()) return OfferToRos2At(now + kStartIsOver);
      OfferToRos2();
    });
  }
  if (hooks_.on_set_up) hooks_.on_set_up();
}

void ActuatorShell::Do(const actuator_action::Finish& action) {
  if (publish_later_) Publish();
  FinishAfterLastQuery({action.code, action.message}, node_.loop().Now() + kLastQueryTime);
}

void ActuatorShell::FinishAfterLastQuery(const Error& end, Time deadline) {
  const Time now = node_.loop().Now();
  if (!managed_node_ || !managed_node_->Holds() || now >= deadline) return hooks_.on_finished(end);
  finish_later_ = node_.loop().At(now + kLastQueryPeriod,
                                  [this, end, deadline] { FinishAfterLastQuery(end, deadline); });
}

// Stamps only grow: of two reports with the same time the later one counts.
msg::ActuatorStatus ActuatorShell::Status() {
  last_stamp_ = std::max(node_.loop().Now(), last_stamp_ + Duration(1));
  ActuatorReport report = core_.report;
  report.stamp = last_stamp_;
  msg::ActuatorStatus status = transport::ToMessage(actuator_.name, report);
  status.machine = machine_.name;
  status.machine_id = machine_.id;
  status.participant = node_.participant().value();
  status.stop_trouble = StopTrouble();
  return status;
}

// A callback on the way up may switch on again after the stop action, which runs once more at its
// end: until then the actuator is not stopped.
std::string ActuatorShell::StopTrouble() const {
  if (core_.report.emergency_stop == 0) return "";
  std::string trouble = hooks_.stop_trouble ? hooks_.stop_trouble() : "";
  if (!trouble.empty()) return trouble;
  const State running = StillSwitchingOn(config_, core_);
  return running.empty() ? ""
                         : "its callback for " + running + " still runs and may switch on again";
}

}  // namespace musher
