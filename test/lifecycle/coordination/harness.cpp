#include "musher/test/lifecycle/coordination/harness.hpp"

#include <algorithm>
#include <utility>

namespace musher::testing {
namespace {

constexpr Duration kWire = std::chrono::microseconds(100);

}  // namespace

MachineConfig MachineOf(int actuators) {
  MachineConfig config;
  config.name = "test";
  for (const std::string_view state : BuiltInStates()) {
    if (state != kUninitialized) config.states.emplace_back(state);
    if (const auto rank = BuiltInRank(state)) config.ranks[State(state)] = *rank;
  }
  config.flow = DefaultFlow(config.states);
  config.default_time = Milliseconds(100);
  for (int i = 0; i < actuators; ++i) {
    ActuatorConfig actuator;
    actuator.name = std::string(1, static_cast<char>('a' + i));
    actuator.states = config.states;
    actuator.times.assign(config.states.size(), Milliseconds(100));
    config.actuators.push_back(actuator);
  }
  return config;
}

ActuatorConfig& ActuatorNamed(MachineConfig& config, const std::string& name) {
  return config.actuators[*config.IndexOf(name)];
}

Harness::Harness(MachineConfig config)
    : FakeRobot(own_config_, own_controller_),
      own_config_(std::move(config)),
      fakes_(own_config_.actuators.size()) {
  controller_.machine = MakeMachine(config_);
}

Behaviour& Harness::On(const std::string& actuator, const std::string& state) {
  return fakes_[Index(actuator)].script[state];
}

void Harness::After(Duration delay, std::function<void()> what) {
  later_.emplace(controller_.now + delay, std::move(what));
}

bool Harness::StepTime(Time limit) {
  const auto deadline = NextDeadline(config_, machine());
  const bool timer_first = deadline && (later_.empty() || *deadline < later_.begin()->first);
  if (!timer_first && later_.empty()) return false;
  const Time next = timer_first ? *deadline : later_.begin()->first;
  if (next > limit) return false;
  controller_.now = std::max(controller_.now, next);
  if (timer_first) {
    Feed(event::TimePassed{});
  } else {
    const auto what = std::move(later_.begin()->second);
    later_.erase(later_.begin());
    what();
  }
  return true;
}

void Harness::RunFor(Duration duration) {
  const Time end = controller_.now + duration;
  while (StepTime(end)) {
  }
  controller_.now = end;
}

void Harness::Rest(Duration limit) {
  const Time end = controller_.now + limit;
  while (StepTime(end)) {
  }
}

bool Harness::RunUntil(const std::function<bool()>& done) {
  const Time end = controller_.now + std::chrono::hours(1);
  while (!done()) {
    if (!StepTime(end)) return done();
  }
  return true;
}

void Harness::StepController(const Event& event) {
  const auto actions = Step(config_, controller_.machine, event, controller_.now);
  for (const Action& action : actions) Apply(action);
  CheckInvariants(config_, controller_.machine);
  was_timer = std::holds_alternative<event::TimePassed>(event);
  if (after_step) after_step();
}

void Harness::Begin(bool by_hand, Epoch epoch, bool restarted) {
  for (const ActuatorIndex i : fakes_.Indices()) {
    const ActuatorConfig& actuator = config_.actuators[i];
    if (actuator.command.empty() && !fakes_[i].alive) StartActuator(actuator.name);
  }
  controller_.disk.epoch = epoch;
  BeginController(by_hand, restarted, supervised);
}

// A disk thread that ended with the controller's process does not answer the next one.
void Harness::Save(Stored what, SaveNumber save, std::function<void(Disk&)> write) {
  const auto end = [=, this, generation = controller_.generation] {
    if (generation != controller_.generation) return;
    if (disk_fails.empty()) write(controller_.disk);
    Feed(event::SaveEnded{what, save, disk_fails.empty(), disk_fails});
  };
  if (disk_takes) After(*disk_takes, end);
}

void Harness::RestartController(bool lost_disk, bool restarted) {
  ++controller_.generation;
  controller_.machine = MakeMachine(config_);
  start_up_.reset();
  Begin(false, lost_disk ? 0 : controller_.disk.epoch, restarted);
  for (const ActuatorConfig& actuator : config_.actuators) RepeatStatus(actuator.name);
}

void Harness::RepeatStatus(const std::string& name) {
  const ActuatorIndex i = Index(name);
  if (!fakes_[i].alive) return;
  After(kWire, [this, i] { Feed(event::StatusSeen{i, Report(i)}); });
}

RequestId Harness::SendPolicyRequest(event::PolicyRequested requested) {
  requested.request = next_request_++;
  Feed(requested);
  return requested.request;
}

void Harness::StartActuator(const std::string& name) {
  const ActuatorIndex i = Index(name);
  ScriptedActuator next;
  next.script = std::move(fakes_[i].script);
  next.Launch(next_pid_++);
  fakes_[i] = std::move(next);
  After(kWire, [this, i, pid = fakes_[i].pid()] {
    if (fakes_[i].pid() != pid) return;
    StepActuator(i, actuator_event::Started{});
    for (const StopId stop : latched_stops_) {
      StepActuator(i, actuator_event::EmergencyStopReceived{stop, true, 0});
    }
  });
}

void Harness::Crash(const std::string& name) {
  EndProcess(Index(name), false, "killed by SIGKILL");
}

void Harness::Exit(const std::string& name, int code, const std::string& words) {
  EndProcess(Index(name), false, "exit code " + std::to_string(code) + ": " + words, code);
}

void Harness::EndProcess(ActuatorIndex i, bool clean, const std::string& how, int exit_code) {
  ScriptedActuator& fake = fakes_[i];
  if (!fake.alive) return;
  fake.alive = false;
  After(kWire,
        [this, end = event::ProcessEnded{i, fake.pid(), clean, how, exit_code}] { FeedExit(end); });
}

// Its last heartbeat was a while ago, or its heartbeat reports that its work thread hangs.
void Harness::Find(const std::string& name, Health health, bool silent) {
  const ActuatorIndex i = Index(name);
  Feed(event::HealthChanged{i, fakes_[i].core.report.incarnation, health, silent,
                            "as the test says"});
}

void Harness::StopAll(StopId id, const std::string& by) {
  PublishStop(id, true, 0);
  After(kWire, [this, id, by] { Feed(event::EmergencyStopSeen{{id, by, ""}}); });
}

void Harness::PublishStop(StopId id, bool engaged, Sender sender) {
  if (engaged) latched_stops_.insert(id);
  if (!engaged) latched_stops_.erase(id);
  const actuator_event::EmergencyStopReceived stop{id, engaged, sender};
  for (const ActuatorIndex i : fakes_.Indices()) After(kWire, [=, this] { StepActuator(i, stop); });
}

RequestId Harness::Restart(const std::string& name) {
  const RequestId request = next_request_++;
  Feed(event::RestartRequested{request, name});
  return request;
}

RequestId Harness::Release() {
  const RequestId request = next_request_++;
  Feed(event::ReleaseRequested{request, "the test"});
  return request;
}

Result<> Harness::Released() {
  const RequestId request = Release();
  RunUntil([&] { return calls.count(request) > 0; });
  return calls.at(request);
}

void Harness::ReceiveRivalHeartbeat(Epoch epoch) {
  Feed(event::RivalSeen{epoch, "process 1 elsewhere", false});
}

void Harness::Mute(const std::string& name, bool to_actuator, bool from_actuator) {
  fakes_[Index(name)].rx_blocked = to_actuator;
  fakes_[Index(name)].tx_blocked = from_actuator;
}

RequestId Harness::RequestSwitch(const State& target, std::optional<std::string> actuator,
                                 const Requester& by) {
  const RequestId request = next_request_++;
  Feed(event::SetStateRequested{request, target, std::move(actuator), AfterTearDown::kStaysDown,
                                by});
  return request;
}

SwitchResult Harness::Set(const State& target, std::optional<std::string> actuator,
                          const Requester& by) {
  const RequestId request = RequestSwitch(target, std::move(actuator), by);
  RunUntil([&] { return answers.count(request) > 0; });
  return answers.at(request);
}

State Harness::StateOf(const std::string& actuator) const {
  return fakes_[Index(actuator)].core.report.state;
}

const KnownActuator& Harness::RecordOf(const std::string& actuator) const {
  return machine().actuators[Index(actuator)];
}

const ActuatorCore& Harness::CoreOf(const std::string& actuator) const {
  return fakes_[Index(actuator)].core;
}

void Harness::StepActuator(ActuatorIndex i, const ActuatorEvent& event) {
  if (!fakes_[i].alive) return;
  const auto actions = Step(config_, i, fakes_[i].core, event, controller_.now);
  for (const ActuatorAction& action : actions) Do(i, action);
}

RequestToken Harness::TokenOf(Sender sender, CommandNumber number, bool query) {
  const RequestToken token(requests_.size());
  requests_.emplace_back(sender, number, query);
  return token;
}

void Harness::Send(const Message& message) {
  After(kWire, [=, this] {
    if (!fakes_[message.to].rx_blocked) Deliver(message);
  });
}

void Harness::Do(ActuatorIndex i, const ActuatorAction& action) {
  ScriptedActuator& fake = fakes_[i];
  const auto end_callback = [this, i](const actuator_event::CallbackEnded& ended) {
    return [=, this, run = fakes_[i].run, pid = fakes_[i].pid()] {
      if (fakes_[i].run != run || fakes_[i].pid() != pid) return;
      ++fakes_[i].run;
      StepActuator(i, ended);
    };
  };
  if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
    log_.push_back(config_.actuators[i].name + ":" + run->target);
    const auto own = fake.script.find(run->target);
    const auto common = fake.script.find("");
    const Behaviour behaviour = own != fake.script.end()      ? own->second
                                : common != fake.script.end() ? common->second
                                                              : Behaviour{};
    ++fake.run;
    fake.hanging = behaviour.ends_when_requested;
    if (!behaviour.hangs && !behaviour.ends_when_requested) {
      After(behaviour.takes, end_callback({behaviour.code, behaviour.message,
                                           behaviour.degraded_code, behaviour.degraded_reason}));
    }
  } else if (std::holds_alternative<actuator_action::RequestStop>(action)) {
    if (fake.hanging) After(kWire, end_callback({kCodeFailed, "stopped on request"}));
    fake.hanging = false;
  } else if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
    const std::uint64_t token = answer->token.value();
    if (token >= requests_.size() || fake.tx_blocked) return;
    const auto& [sender, number, query] = requests_[token];
    const event::Replied reply{
        i, number, query, answer->verdict, answer->code, answer->message, Report(i)};
    After(kWire + fake.delay, [this, reply, sender = sender] {
      if (sender == controller_.sender()) Feed(reply);
    });
  } else if (std::holds_alternative<actuator_action::BecomeVisible>(action)) {
    fake.visible = true;
  } else if (std::holds_alternative<actuator_action::PublishStatus>(action)) {
    if (fake.tx_blocked) return;
    After(kWire + fake.delay, [this, seen = event::StatusSeen{i, Report(i)}] { Feed(seen); });
  } else if (const auto* finish = std::get_if<actuator_action::Finish>(&action)) {
    if (shared.contains(config_.actuators[i].name) && finish->code == kCodeOk) return;
    After(kWire * 3, [this, i, clean = finish->code == kCodeOk] {
      EndProcess(i, clean, clean ? "exit code 0" : "exit code 1", clean ? 0 : 1);
    });
  }
}

void Harness::StartProcess(ActuatorIndex i) {
  const Behaviour exec = fakes_[i].script["exec"];
  if (exec.code != kCodeOk) return Feed(event::ProcessNotStarted{i, exec.message});
  StartActuator(config_.actuators[i].name);
  Feed(event::ProcessStarted{i, fakes_[i].pid()});
  if (exec.exit_code != 0) Exit(config_.actuators[i].name, exec.exit_code, exec.message);
}

void Harness::Do(const Action& action) {
  if (const auto* start = std::get_if<action::StartProcess>(&action)) {
    StartProcess(start->actuator);
  } else if (const auto* signal = std::get_if<action::SignalProcess>(&action)) {
    const std::string name = signal->kill ? "KILL" : "TERM";
    signals.push_back(config_.actuators[signal->actuator].name + ":" + name);
    if (fakes_[signal->actuator].script[name].hangs) return;
    EndProcess(signal->actuator, false, "killed by SIG" + name);
  } else if (const auto* answer = std::get_if<action::AnswerSetState>(&action)) {
    answers[answer->request] = answer->result;
  } else if (const auto* call = std::get_if<action::AnswerCall>(&action)) {
    calls.emplace(call->request, call->result);
  } else if (const auto* take = std::get_if<action::TakeBacktrace>(&action)) {
    After(Milliseconds(50), [this, take = *take] {
      Feed(event::BacktraceTaken{take.actuator, take.pid, "in its main loop"});
    });
  } else if (const auto* stop = std::get_if<action::PublishEmergencyStop>(&action)) {
    if (!lost_stops) PublishStop(stop->stop.id, stop->engaged, controller_.sender());
  } else if (const auto* command = std::get_if<action::RunPowerCommand>(&action)) {
    power.emplace_back(now(), command->reboot);
  } else if (const auto* end = std::get_if<action::Fenced>(&action)) {
    fenced = end->message;
  } else if (const auto* record = std::get_if<action::Record>(&action)) {
    records.push_back(*record);
    if (record->id == 1) whole_records.clear();
    whole_records.push_back(*record);
  } else if (const auto* ended = std::get_if<action::StartUpEnded>(&action)) {
    start_up_ = *ended;
  } else if (std::holds_alternative<action::Stopped>(action)) {
    stopped_ = true;
  }
}

}  // namespace musher::testing
