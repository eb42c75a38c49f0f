#include "musher/test/lifecycle/coordination/harness.hpp"

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
    : config_(std::move(config)),
      machine_(MakeMachine(config_)),
      fakes_(config_.actuators.size()),
      now_(std::chrono::hours(1)) {}

Behaviour& Harness::On(const std::string& actuator, const std::string& state) {
  return fakes_[Index(actuator)].script[state];
}

void Harness::After(Duration delay, std::function<void()> what) {
  later_.emplace(now_ + delay, std::move(what));
}

bool Harness::StepTime(Time limit) {
  const auto deadline = NextDeadline(config_, machine_);
  const bool timer_first = deadline && (later_.empty() || *deadline < later_.begin()->first);
  if (!timer_first && later_.empty()) return false;
  const Time next = timer_first ? *deadline : later_.begin()->first;
  if (next > limit) return false;
  now_ = std::max(now_, next);
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
  const Time end = now_ + duration;
  while (StepTime(end)) {
  }
  now_ = end;
}

void Harness::Rest(Duration limit) {
  const Time end = now_ + limit;
  while (StepTime(end)) {
  }
}

bool Harness::RunUntil(const std::function<bool()>& done) {
  const Time end = now_ + std::chrono::hours(1);
  while (!done()) {
    if (!StepTime(end)) return done();
  }
  return true;
}

void Harness::Feed(const Event& event) {
  for (const Action& action : Step(config_, machine_, event, now_)) Do(action);
  CheckInvariants(config_, machine_);
  if (after_step) after_step();
}

void Harness::Begin(bool by_hand, Epoch epoch, bool restarted) {
  PerActuator<bool> running;
  for (const ActuatorIndex i : fakes_.Indices()) {
    if (config_.actuators[i].command.empty() && !fakes_[i].alive) {
      StartActuator(config_.actuators[i].name);
    }
    running.push_back(fakes_[i].alive);
  }
  Feed(event::Begin{by_hand,
                    epoch,
                    running,
                    "here",
                    stops_on_disk,
                    {},
                    policy_on_disk,
                    stop_intent_on_disk,
                    restarted});
}

// A disk thread that ended with the controller's process does not answer the next one.
template <class T>
void Harness::Save(Stored what, SaveNumber save, T& stored, T value) {
  const auto end = [this, what, save, &stored, value = std::move(value), generation = generation_] {
    if (generation != generation_) return;
    if (disk_fails.empty()) stored = value;
    Feed(event::SaveEnded{what, save, disk_fails.empty(), disk_fails});
  };
  if (disk_takes) After(*disk_takes, end);
}

void Harness::RestartController(bool lost_disk, bool restarted) {
  ++generation_;
  machine_ = MakeMachine(config_);
  start_up_.reset();
  Begin(false, lost_disk ? 0 : epoch_on_disk_, restarted);
  for (const ActuatorConfig& actuator : config_.actuators) RepeatStatus(actuator.name);
}

void Harness::RepeatStatus(const std::string& name) {
  const ActuatorIndex i = Index(name);
  if (!fakes_[i].alive) return;
  After(kWire, [this, i] { Feed(event::StatusSeen{i, ReportOf(i)}); });
}

RequestId Harness::SendPolicyRequest(event::PolicyRequested requested) {
  requested.request = next_request_++;
  Feed(requested);
  return requested.request;
}

void Harness::StartActuator(const std::string& name) {
  FakeActuator& fake = fakes_[Index(name)];
  auto script = fake.script;
  fake = FakeActuator{};
  fake.script = std::move(script);
  fake.alive = true;
  fake.pid = next_pid_++;
  fake.core.report.incarnation = Incarnation(static_cast<std::uint64_t>(fake.pid));
  fake.core.report.pid = fake.pid;
  fake.core.report.host = "here";
  After(kWire, [this, i = Index(name), pid = fake.pid] {
    if (fakes_[i].pid != pid) return;
    StepCore(i, actuator_event::Started{});
    for (const StopId stop : latched_stops_) {
      StepCore(i, actuator_event::EmergencyStopReceived{stop, true, 0});
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
  FakeActuator& fake = fakes_[i];
  if (!fake.alive) return;
  fake.alive = false;
  After(kWire, [=, this, pid = fake.pid] {
    const bool ours = machine_.actuators[i].process.pid == pid;
    if (ours) return Feed(event::ProcessEnded{i, pid, clean, how, exit_code});
    Feed(event::Vanished{i, Incarnation(static_cast<std::uint64_t>(pid)), true,
                         "its process ended"});
  });
}

// Its last heartbeat was a while ago, or its heartbeat reports that its work thread hangs.
void Harness::Find(const std::string& name, Health health, bool silent) {
  const ActuatorIndex i = Index(name);
  Feed(event::HealthChanged{i, fakes_[i].core.report.incarnation, health, silent,
                            "as the test says"});
}

void Harness::StopAll(StopId id, const std::string& by) {
  latched_stops_.insert(id);
  const actuator_event::EmergencyStopReceived stop{id, true, 0};
  for (const ActuatorIndex i : fakes_.Indices()) After(kWire, [=, this] { StepCore(i, stop); });
  After(kWire, [this, id, by] { Feed(event::EmergencyStopSeen{{id, by, ""}}); });
}

void Harness::PublishToActuators(const action::PublishEmergencyStop& stop) {
  if (stop.engaged) latched_stops_.insert(stop.stop.id);
  if (!stop.engaged) latched_stops_.erase(stop.stop.id);
  for (const ActuatorIndex i : fakes_.Indices()) {
    After(kWire, [=, this, sender = ControllerId()] {
      StepCore(i, actuator_event::EmergencyStopReceived{stop.stop.id, stop.engaged, sender});
    });
  }
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

void Harness::ReceiveRivalHeartbeat(Epoch epoch) {
  Feed(event::RivalSeen{epoch, "process 1 elsewhere", false});
}

void Harness::Mute(const std::string& name, bool to_actuator, bool from_actuator) {
  fakes_[Index(name)].rx_blocked = to_actuator;
  fakes_[Index(name)].tx_blocked = from_actuator;
}

RequestId Harness::RequestSwitch(const State& target, std::optional<std::string> actuator) {
  const RequestId request = next_request_++;
  Feed(event::SetStateRequested{request, target, std::move(actuator)});
  return request;
}

SwitchResult Harness::Set(const State& target, std::optional<std::string> actuator) {
  const RequestId request = RequestSwitch(target, std::move(actuator));
  RunUntil([&] { return answers.count(request) > 0; });
  return answers.at(request);
}

State Harness::StateOf(const std::string& actuator) const {
  return fakes_[Index(actuator)].core.report.state;
}

const ActuatorRecord& Harness::RecordOf(const std::string& actuator) const {
  return machine_.actuators[Index(actuator)];
}

const ActuatorCore& Harness::CoreOf(const std::string& actuator) const {
  return fakes_[Index(actuator)].core;
}

ActuatorReport Harness::ReportOf(ActuatorIndex i) const {
  ActuatorReport report = fakes_[i].core.report;
  report.stamp = now_;
  return report;
}

std::vector<ActuatorAction> Harness::Inject(const std::string& actuator,
                                            const ActuatorEvent& event) {
  const ActuatorIndex i = Index(actuator);
  auto actions = Step(config_, i, fakes_[i].core, event, now_);
  for (const ActuatorAction& action : actions) Do(i, action);
  return actions;
}

void Harness::StepCore(ActuatorIndex i, const ActuatorEvent& event) {
  if (!fakes_[i].alive) return;
  for (const ActuatorAction& action : Step(config_, i, fakes_[i].core, event, now_)) {
    Do(i, action);
  }
}

void Harness::Do(ActuatorIndex i, const ActuatorAction& action) {
  FakeActuator& fake = fakes_[i];
  const std::string& name = config_.actuators[i].name;
  const auto end_callback = [this, i](const actuator_event::CallbackEnded& ended) {
    return [=, this, run = fakes_[i].run, pid = fakes_[i].pid] {
      if (fakes_[i].run != run || fakes_[i].pid != pid) return;
      ++fakes_[i].run;
      StepCore(i, ended);
    };
  };
  if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
    log_.push_back(name + ":" + run->target);
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
    const auto request = fake.requests.extract(answer->token);
    if (request.empty() || fake.tx_blocked) return;
    After(kWire + fake.delay, [this, i, answer = *answer, number = request.mapped().first,
                               query = request.mapped().second, report = ReportOf(i),
                               generation = generation_] {
      if (generation != generation_) return;
      Feed(event::Replied{i, number, query, answer.verdict, answer.code, answer.message, report});
    });
  } else if (std::holds_alternative<actuator_action::PublishStatus>(action)) {
    if (fake.tx_blocked) return;
    After(kWire + fake.delay, [this, i, report = ReportOf(i)] {
      Feed(event::StatusSeen{i, report});
    });
  } else if (std::holds_alternative<actuator_action::BecomeVisible>(action)) {
    fake.visible = true;
  } else if (const auto* finish = std::get_if<actuator_action::Finish>(&action)) {
    if (shared.contains(config_.actuators[i].name) && finish->code == kCodeOk) return;
    After(kWire * 3, [this, i, clean = finish->code == kCodeOk] {
      EndProcess(i, clean, clean ? "exit code 0" : "exit code 1", clean ? 0 : 1);
    });
  }
}

void Harness::Do(const Action& action) {
  const auto deliver = [this](ActuatorIndex i, CommandNumber number, bool query, auto make_event) {
    const RequestToken token = next_token_++;
    After(kWire, [=, this, sender = ControllerId(), epoch = machine_.epoch] {
      FakeActuator& fake = fakes_[i];
      if (!fake.alive || !fake.visible || fake.rx_blocked) return;
      fake.requests[token] = {number, query};
      StepCore(i, actuator_event::ControllerHeartbeatReceived{sender, epoch});
      StepCore(i, make_event(token));
    });
  };
  const Sender sender = ControllerId();
  if (const auto* send = std::get_if<action::SendSwitch>(&action)) {
    deliver(send->actuator, send->command.number, false,
            [command = send->command, sender](RequestToken token) {
              return ActuatorEvent{actuator_event::SwitchArrived{token, command, sender}};
            });
  } else if (const auto* query = std::get_if<action::SendQuery>(&action)) {
    deliver(query->actuator, query->command.number, true,
            [command = query->command, sender](RequestToken token) {
              return ActuatorEvent{actuator_event::QueryArrived{token, command, sender}};
            });
  } else if (const auto* start = std::get_if<action::StartProcess>(&action)) {
    const Behaviour exec = fakes_[start->actuator].script["exec"];
    if (exec.code != kCodeOk) return Feed(event::ProcessNotStarted{start->actuator, exec.message});
    StartActuator(config_.actuators[start->actuator].name);
    Feed(event::ProcessStarted{start->actuator, fakes_[start->actuator].pid});
    if (exec.exit_code != 0) {
      Exit(config_.actuators[start->actuator].name, exec.exit_code, exec.message);
    }
  } else if (std::holds_alternative<action::FindProcesses>(action)) {
    event::ProcessesFound found;
    for (const FakeActuator& fake : fakes_) found.processes.push_back(fake.alive ? fake.pid : 0);
    Feed(found);
  } else if (const auto* signal = std::get_if<action::SignalProcess>(&action)) {
    signals.push_back(config_.actuators[signal->actuator].name +
                      (signal->kill ? ":KILL" : ":TERM"));
    const bool obeys = !fakes_[signal->actuator].script[signal->kill ? "KILL" : "TERM"].hangs;
    if (obeys) {
      EndProcess(signal->actuator, false, signal->kill ? "killed by SIGKILL" : "killed by SIGTERM");
    }
  } else if (const auto* answer = std::get_if<action::AnswerSetState>(&action)) {
    answers[answer->request] = answer->result;
  } else if (const auto* call = std::get_if<action::AnswerCall>(&action)) {
    calls.emplace(call->request, call->result);
  } else if (const auto* take = std::get_if<action::TakeBacktrace>(&action)) {
    After(Milliseconds(50), [this, take = *take] {
      Feed(event::BacktraceTaken{take.actuator, take.pid, "in its main loop"});
    });
  } else if (const auto* stop = std::get_if<action::PublishEmergencyStop>(&action)) {
    PublishToActuators(*stop);
  } else if (const auto* stops = std::get_if<action::SaveEmergencyStops>(&action)) {
    Save(Stored::kEmergencyStops, stops->save, stops_on_disk, stops->stops);
  } else if (const auto* policy = std::get_if<action::SavePolicy>(&action)) {
    Save(Stored::kPolicy, policy->save, policy_on_disk, policy->policy);
  } else if (const auto* intent = std::get_if<action::SaveStopIntent>(&action)) {
    Save(Stored::kStopIntent, intent->save, stop_intent_on_disk, intent->intended);
  } else if (const auto* command = std::get_if<action::RunPowerCommand>(&action)) {
    power.emplace_back(now_, command->reboot);
  } else if (const auto* epoch = std::get_if<action::SaveEpoch>(&action)) {
    Save(Stored::kEpoch, epoch->save, epoch_on_disk_, epoch->epoch);
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
