#include "musher/search/harness.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/search/rules.hpp"

namespace musher::search {
namespace {

// How far each actuator's clock is ahead of its stamps.
constexpr Duration kClockAhead = Milliseconds(1);
constexpr StopId kStopId = 5;
constexpr Sender kOtherMachine(99);  // more than controllers that take over

// A host is silent once heartbeats have been missing for 500 ms (health_monitor.hpp), by a loop
// that may be late.
constexpr Duration kSilentWithin = Milliseconds(1000);
// A start waits for its host for 10 s before that is reported (host_units.hpp).
constexpr Duration kAwaitedWithin = Milliseconds(10'000);

}  // namespace

bool FromActuator(const Late& late) {
  return std::holds_alternative<event::Replied>(late) ||
         std::holds_alternative<event::StatusSeen>(late);
}

void Harness::Log(const std::string& sentence) {
  if (notes_.log) notes_.scenario.push_back(sentence);
}

void Harness::StepController(const Event& event) {
  const auto* begin = std::get_if<event::Begin>(&event);
  begin != nullptr ? StepWith(BeginHere(*begin)) : StepWith(event);
}

void Harness::StepWith(const Event& event) {
  Machine& machine = world_.machine;
  // The controller has ended, or is about to and can only refuse.
  const bool requested = std::holds_alternative<event::SetStateRequested>(event);
  if (machine.phase == Phase::kStopped && !requested) return;
  const bool starting = machine.current && machine.current->purpose == Purpose::kStartUpActivate;
  const Before before{machine.state, machine.phase, machine.emergency.stop.has_value(), starting};
  const auto actions = model_.rules.controller(config_, machine, event, world_.now);
  for (const Action& action : actions) {
    const auto* send = std::get_if<action::SendSwitch>(&action);
    if (send != nullptr) CheckCommand(model_, world_, *send, notes_);
    if (std::holds_alternative<action::FindProcesses>(action)) {
      Feed(FindProcesses());
    } else {
      Apply(action);
    }
  }
  CheckStep(model_, world_, before, notes_);
  CheckTimedRules();
}

void Harness::Wait() {
  const Time end = *EndOfWait(model_, world_);
  Log("almost " + std::to_string(ToMilliseconds(end + Duration(1) - world_.now)) + " ms pass");
  world_.now = end;
}

void Harness::CheckTimedRules() {
  if (!model_.timed_rules.empty()) UpdateTimedRules(model_, world_, notes_);
}

void Harness::RequestSwitch(const State& target) {
  world_.requests.push_back({target});
  Log("a caller requests " + target);
  Feed(event::SetStateRequested{RequestId(world_.requests.size()), target, std::nullopt});
}

void Harness::RestartController(bool by_person) {
  World& w = world_;
  w.stays_down = !by_person && (w.stays_down || w.disk.stop_intent);
  ++w.generation;
  if (w.repeat == Repeat::kDone) w.repeat = Repeat::kRequested;
  w.machine = MakeMachine(config_);
  CheckTimedRules();  // no controller leads: their times begin again
  w.outbox.clear();
  for (Request& request : w.requests) request.abandoned |= request.replies == 0;
  w.stop_seen_due = w.stopped && !w.released && w.disk.stops.engaged.empty();
  for (SimActuator& actuator : w.actuators) {
    actuator.replies.clear();
    actuator.end.reset();
    actuator.status_due = actuator.alive;  // latched for the next controller
    std::erase_if(actuator.late, FromActuator);
    actuator.hang_due = actuator.hung;
    actuator.backtrace_due = false;
    actuator.unit_report = UnitReport::kNone;
    actuator.wanted = actuator.killed = actuator.silent = false;
    actuator.await_by.reset();
  }
  for (Link& link : w.links) link.silent_by.reset();
  w.battery_due = w.battery.has_value();
  for (const ActuatorIndex i : w.actuators.Indices()) {
    if (IsElsewhere(i) && w.actuators[i].alive) w.actuators[i].unit_report = UnitReport::kFound;
  }
  BeginController(false, /*restarted=*/!by_person, /*supervised=*/!by_person);
}

// One sample lowers the machine; so many decide that the battery is empty.
void Harness::FeedBattery() {
  world_.battery_due = false;
  const bool empty = *world_.battery == BatteryLevels(config_).back();
  for (int sample = 0; sample < (empty ? kConfirmingSamples : 1); ++sample) {
    Feed(event::BatterySeen{*world_.battery, false, 0});
  }
}

void Harness::FeedReply(ActuatorIndex i) {
  auto& replies = world_.actuators[i].replies;
  const event::Replied reply = std::move(replies.front());
  replies.erase(replies.begin());
  Feed(reply);
}

void Harness::FeedStatus(ActuatorIndex i) {
  world_.actuators[i].status_due = false;
  FeedStatus(event::StatusSeen{i, Report(i)});
  if (world_.actuators[i].silent) FeedHeartbeat(i);
}

// The end of the process was detected: the shell finds none with its pid, and its writer is lost.
void Harness::FeedStatus(event::StatusSeen seen) {
  const SimActuator& actuator = world_.actuators[seen.actuator];
  const Incarnation incarnation = seen.report.incarnation;
  const bool of_present = incarnation == actuator.core.report.incarnation;
  const bool ended = !of_present || (!actuator.alive && !actuator.end);
  if (ended && !IsElsewhere(seen.actuator)) seen.report.pid = 0;
  Feed(seen);
  if (ended) Feed(event::Vanished{seen.actuator, incarnation, false, "its writer is lost"});
}

void Harness::FeedEnd(ActuatorIndex i) {
  const bool clean = *std::exchange(world_.actuators[i].end, std::nullopt);
  if (IsElsewhere(i)) return FeedUnitEnd(i, clean);
  FeedExit({i, world_.actuators[i].pid(), clean, clean ? "exit code 0" : "killed"});
}

// --- links to other hosts ---

// systemd reports first that a process has started, then its exit. Of a process that it has not
// reported as found yet it reports no exit: a start finds none, and else its heartbeats are
// missing.
void Harness::FeedUnitEnd(ActuatorIndex i, bool clean) {
  SimActuator& actuator = world_.actuators[i];
  const std::int32_t pid = actuator.pid();
  const bool wanted = std::exchange(actuator.wanted, false);
  const UnitReport report = std::exchange(actuator.unit_report, UnitReport::kNone);
  if (report == UnitReport::kStarted) {
    Feed(event::ProcessStarted{i, pid, actuator.core.report.host, false});
  }
  if (world_.machine.actuators[i].process.pid == pid) {
    return Feed(event::ProcessEnded{i, pid, clean, clean ? "exit code 0" : "killed"});
  }
  if (wanted) return StartLate(i);
  const Incarnation incarnation = actuator.core.report.incarnation;
  Feed(event::HealthChanged{i, incarnation, Health::kCrashed, true, "no heartbeat"});
}

// Whether heartbeats are expected of it: it has published a status.
bool Harness::IsMonitored(ActuatorIndex i) const {
  const KnownActuator& known = world_.machine.actuators[i];
  return known.report.incarnation != 0 && known.report.incarnation != known.process.dead;
}

// A start whose end was not reported yet is one that waits.
void Harness::CutLink(std::size_t host) {
  Link& link = world_.links[host];
  link.cut = true;
  for (const ActuatorIndex i : world_.actuators.Indices()) {
    if (HostOf(i) != host) continue;
    SimActuator& actuator = world_.actuators[i];
    actuator.replies.clear();
    if (IsMonitored(i)) link.silent_by = world_.now + kSilentWithin;
    actuator.unit_report = UnitReport::kNone;
    if (actuator.wanted) actuator.await_by = world_.now + kAwaitedWithin;
  }
}

void Harness::RebootHost(std::size_t host) {
  for (const ActuatorIndex i : world_.actuators.Indices()) {
    if (HostOf(i) == host && world_.actuators[i].alive) EndProcess(i, false);
  }
  ++world_.links[host].boots;
  CutLink(host);
}

void Harness::NoticeCut(std::size_t host) {
  world_.links[host].silent_by.reset();
  for (const ActuatorIndex i : world_.actuators.Indices()) {
    if (HostOf(i) != host || !IsMonitored(i)) continue;
    const Incarnation incarnation = world_.machine.actuators[i].report.incarnation;
    SimActuator& actuator = world_.actuators[i];
    actuator.silent = actuator.alive && incarnation == actuator.core.report.incarnation;
    Feed(event::HealthChanged{i, incarnation, Health::kPartitioned, true, "no heartbeat"});
  }
}

// What systemd knows of a process that this controller does not is reported. Signals and starts
// that have waited are carried out, if they are still wanted.
void Harness::Reach(std::size_t host) {
  world_.links[host].cut = false;
  const Phase phase = world_.machine.phase;
  for (const ActuatorIndex i : world_.actuators.Indices()) {
    if (HostOf(i) != host) continue;
    SimActuator& actuator = world_.actuators[i];
    actuator.await_by.reset();
    const ActuatorProcess& known = world_.machine.actuators[i].process;
    const bool still_ends = phase == Phase::kStopping ||
                            (known.termination && known.termination->pid == actuator.pid());
    if (std::exchange(actuator.killed, false) && still_ends) EndProcess(i, false);
    actuator.status_due = actuator.alive;
    const bool wanted = std::exchange(actuator.wanted, false);
    if (actuator.alive) {
      if (wanted || known.pid != actuator.pid()) actuator.unit_report = UnitReport::kFound;
    } else if (wanted) {
      StartLate(i);
    }
  }
}

void Harness::StartLate(ActuatorIndex i) {
  if (world_.machine.phase != Phase::kStopping) return StartUnit(i);
  Feed(event::ProcessNotStarted{i, "the machine is torn down", false});
}

void Harness::FeedUnitReport(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  const bool found = std::exchange(actuator.unit_report, UnitReport::kNone) == UnitReport::kFound;
  actuator.wanted = false;
  Feed(event::ProcessStarted{i, actuator.pid(), actuator.core.report.host, found});
}

void Harness::FeedWaits(ActuatorIndex i) {
  world_.actuators[i].await_by.reset();
  Feed(event::ProcessNotStarted{i, "host " + HostName(i) + " is out of reach", true});
}

void Harness::FeedHeartbeat(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  actuator.silent = false;
  Feed(event::HealthChanged{i, actuator.core.report.incarnation, Health::kWell, false,
                            "heartbeat received again"});
}

// The controller finds the processes of its own host at once; those of others are reported.
event::Begin Harness::BeginHere(const event::Begin& begin) const {
  event::Begin here = begin;
  for (const ActuatorIndex i : world_.actuators.Indices()) {
    if (!IsElsewhere(i)) continue;
    here.running[i] = false;
    here.processes[i] = 0;
  }
  return here;
}

event::ProcessesFound Harness::FindProcesses() const {
  event::ProcessesFound found;
  const std::size_t count = world_.actuators.size();
  found.processes.resize(count);
  if (!world_.links.empty()) {
    found.hosts.resize(count);
    found.unreached.resize(count);
  }
  for (const ActuatorIndex i : world_.actuators.Indices()) {
    const SimActuator& actuator = world_.actuators[i];
    if (IsElsewhere(i)) found.hosts[i] = actuator.core.report.host;
    if (IsOut(i)) {
      found.unreached[i] = "it does not answer";
    } else if (actuator.alive) {
      found.processes[i] = actuator.pid();
    }
  }
  return found;
}

void Harness::StartUnit(ActuatorIndex i) {
  const bool found = world_.actuators[i].alive && !IsOut(i);
  if (!found && !IsOut(i)) StartActuator(i);
  SimActuator& actuator = world_.actuators[i];
  actuator.wanted = true;
  if (IsOut(i)) {
    actuator.await_by = world_.now + kAwaitedWithin;
  } else {
    actuator.unit_report = found ? UnitReport::kFound : UnitReport::kStarted;
  }
}

void Harness::SignalProcess(const action::SignalProcess& signal) {
  SimActuator& actuator = world_.actuators[signal.actuator];
  if (!actuator.alive || actuator.pid() != signal.pid) return;
  if (!IsOut(signal.actuator)) return EndProcess(signal.actuator, false);
  actuator.killed = true;
}

void Harness::StartActuator(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  SimActuator next;
  next.late = std::move(actuator.late);
  next.processes = actuator.processes + 1;
  next.done = actuator.done;
  actuator = std::move(next);
  actuator.Launch(actuator.processes);
  if (IsElsewhere(i)) {
    const int boots = world_.links[HostOf(i)].boots;
    actuator.core.report.host = HostName(i) + "/" + std::to_string(boots);
  }
  StepActuator(i, actuator_event::Started{});
  if (world_.stopped && !world_.released) ReceiveStop(i);  // its topic is latched
}

void Harness::Transmit(const Message& message) {
  if (!IsOut(message.to)) return Deliver(message);
  const bool arrives = std::holds_alternative<SwitchCommand>(message.what);
  if (arrives && world_.actuators[message.to].visible)
    world_.actuators[message.to].late.emplace_back(message);
}

void Harness::DeliverLate(const Message& message) {
  Work& work = world_.actuators[message.to].work;
  const Work before = work;
  Deliver(message);
  if (before == Work::kNone && work == Work::kRunning) work = Work::kOverdue;
}

// The end of a callback switches the output on, towards a state that is as active or more, or off;
// a self-check switches nothing.
void Harness::EndCallback(ActuatorIndex i, std::int32_t code, const std::string& text) {
  SimActuator& actuator = world_.actuators[i];
  actuator.work = Work::kNone;
  const ActuatorReport& report = actuator.core.report;
  if (code == kCodeOk) actuator.done = std::max(actuator.done, report.busy_number);
  if (code == kCodeOk && config_.RankOf(report.target)) {
    const bool again = report.target != report.state || report.emergency_stop == 0;
    actuator.energised = Rises(config_, report.state, report.target) ||
                         (again && SwitchesOnAgain(config_, report.state, report.target));
  }
  StepActuator(i, actuator_event::CallbackEnded{code, text});
}

void Harness::ReceiveStop(ActuatorIndex i) {
  StepActuator(i, actuator_event::EmergencyStopReceived{kStopId, true, 0});
}

void Harness::ReceiveOtherCommand(ActuatorIndex i, const State& target) {
  const ActuatorReport& report = world_.actuators[i].core.report;
  SwitchCommand command;
  command.epoch = Epoch(report.epoch.value() + 1);
  command.number = CommandNumber(report.number.value() + 1);
  command.target = target;
  command.budget = Milliseconds(100);
  command.status_stamp = world_.now;
  command.incarnation = report.incarnation;
  const RequestToken token = TokenOf(kOtherMachine, command.number, false);
  const ActuatorCore before = world_.actuators[i].core;
  StepActuator(i, actuator_event::SwitchArrived{token, command, kOtherMachine});
  CheckUnchanged(model_, world_, i, before, notes_);
}

void Harness::ReceiveOtherRelease(ActuatorIndex i) {
  const ActuatorCore before = world_.actuators[i].core;
  StepActuator(i, actuator_event::EmergencyStopReceived{kStopId, false, kOtherMachine});
  CheckUnchanged(model_, world_, i, before, notes_);
}

void Harness::Crash(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  actuator.status_due = false;
  EndProcess(i, false);
  if (!IsOut(i)) FeedEnd(i);
}

void Harness::HangWorkThread(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  actuator.hung = true;
  if (actuator.work == Work::kRunning) actuator.work = Work::kOverdue;
  FeedHang(i);
}

void Harness::FeedHang(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  actuator.hang_due = false;
  Feed(event::HealthChanged{i, actuator.core.report.incarnation, Health::kHung, false,
                            "no checkpoint from its work thread"});
}

void Harness::TakeBacktrace(ActuatorIndex i) {
  world_.actuators[i].backtrace_due = false;
  Feed(event::BacktraceTaken{i, world_.actuators[i].pid(), "stacks"});
}

// A controller that has not noticed the hang notices nothing of its end either.
void Harness::MakeProgress(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  actuator.hung = false;
  if (std::exchange(actuator.hang_due, false)) return;
  Feed(event::HealthChanged{i, actuator.core.report.incarnation, Health::kWell, false,
                            "its work thread makes progress again"});
}

void Harness::EndProcess(ActuatorIndex i, bool clean) {
  SimActuator& actuator = world_.actuators[i];
  actuator.alive = actuator.visible = false;
  actuator.work = Work::kNone;
  actuator.silent = actuator.killed = false;
  actuator.hung = actuator.hang_due = actuator.backtrace_due = false;
  actuator.end = clean;
}

void Harness::EngageStop(std::optional<ActuatorIndex> except) {
  world_.stopped = world_.stop_seen_due = true;
  for (const ActuatorIndex i : world_.actuators.Indices()) {
    if (IsOut(i) && world_.actuators[i].alive && i != except) {
      world_.actuators[i].late.emplace_back(StopMessage{});
    } else if (i != except) {
      ReceiveStop(i);
    }
  }
}

void Harness::StepActuator(ActuatorIndex i, const ActuatorEvent& event) {
  SimActuator& actuator = world_.actuators[i];
  if (!actuator.alive) return;
  // The epoch of the command that this event may begin.
  Epoch epoch = actuator.core.waiting ? actuator.core.waiting->command.epoch : 0;
  const auto* arrived = std::get_if<actuator_event::SwitchArrived>(&event);
  if (arrived != nullptr) epoch = arrived->command.epoch;
  const ActuatorReport before = actuator.core.report;
  const auto actions =
      model_.rules.actuator(config_, i, actuator.core, event, world_.now + kClockAhead);
  for (const ActuatorAction& action : actions) {
    if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
      const CommandNumber number = actuator.core.report.busy_number;
      CheckBegin(model_, world_, i, run->target, epoch, number, notes_);
      actuator.begun = std::max(actuator.begun, number);
      actuator.work = actuator.hung ? Work::kOverdue : Work::kRunning;
      actuator.stop_requested = false;
    }
    if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
      if (answer->code != kCodePermissionDenied) actuator.epoch = std::max(actuator.epoch, epoch);
      const auto* query = std::get_if<actuator_event::QueryArrived>(&event);
      if (query != nullptr && answer->verdict == Verdict::kDone) {
        actuator.epoch = std::max(actuator.epoch, query->command.epoch);
        actuator.queried = std::max(actuator.queried, query->command.number);
      }
    }
    Do(i, action);
  }
  CheckStopped(model_, world_, i, before, notes_);
}

// The token of a request holds its number, its kind and its sender.
RequestToken Harness::TokenOf(Sender sender, CommandNumber number, bool query) {
  return RequestToken(number.value() << 8 | static_cast<std::uint64_t>(query) << 7 |
                      sender.value());
}

void Harness::Save(Stored what, SaveNumber save, std::function<void(Disk&)> write) {
  write(world_.disk);
  Feed(event::SaveEnded{what, save, true, {}});
}

void Harness::Do(ActuatorIndex i, const ActuatorAction& action) {
  SimActuator& actuator = world_.actuators[i];
  if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
    Log("  " + Name(i) + " begins " + run->target);
  } else if (std::holds_alternative<actuator_action::RequestStop>(action)) {
    actuator.stop_requested = true;
  } else if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
    const std::uint64_t token = answer->token.value();
    if (Sender(token & 127) != world_.sender()) return;  // its caller has ended
    if (IsOut(i)) return;
    actuator.replies.push_back({i, CommandNumber(token >> 8), (token >> 7 & 1) != 0,
                                answer->verdict, answer->code, answer->message, Report(i)});
  } else if (std::holds_alternative<actuator_action::BecomeVisible>(action)) {
    actuator.visible = true;
  } else if (std::holds_alternative<actuator_action::RunEmergencyStop>(action)) {
    actuator.energised = false;
    actuator.status_due = true;
  } else if (std::holds_alternative<actuator_action::PublishStatus>(action)) {
    actuator.status_due = true;
  } else if (const auto* finish = std::get_if<actuator_action::Finish>(&action)) {
    EndProcess(i, finish->code == kCodeOk);
  }
}

// An actuator that receives the stop late receives all of it late.
void Harness::PublishToActuators(const action::PublishEmergencyStop& published) {
  const auto of_stop = [](const Late& late) { return std::holds_alternative<StopMessage>(late); };
  for (const ActuatorIndex i : world_.actuators.Indices()) {
    const auto& late = world_.actuators[i].late;
    if (!published.engaged) {
      StepActuator(i, actuator_event::EmergencyStopReceived{kStopId, false, world_.sender(), "", "",
                                                            published.last_command});
    } else if (std::none_of(late.begin(), late.end(), of_stop)) {
      if (!IsOut(i)) {
        ReceiveStop(i);
      } else if (world_.actuators[i].alive && world_.actuators[i].core.stops.empty()) {
        world_.actuators[i].late.emplace_back(StopMessage{});
      }
    }
  }
}

void Harness::Do(const Action& action) {
  World& w = world_;
  if (const auto* start = std::get_if<action::StartProcess>(&action)) {
    CheckStart(model_, w, start->actuator, notes_);
    if (IsElsewhere(start->actuator)) return StartUnit(start->actuator);
    StartActuator(start->actuator);
    Feed(event::ProcessStarted{start->actuator, w.actuators[start->actuator].pid()});
  } else if (const auto* signal = std::get_if<action::SignalProcess>(&action)) {
    SignalProcess(*signal);
  } else if (const auto* taken = std::get_if<action::TakeBacktrace>(&action)) {
    w.actuators[taken->actuator].backtrace_due = w.actuators[taken->actuator].hung;
  } else if (const auto* answer = std::get_if<action::AnswerSetState>(&action)) {
    CheckAnswer(model_, w, *answer, notes_);
    const bool switched = answer->result.outcome == SwitchOutcome::kDone ||
                          answer->result.outcome == SwitchOutcome::kDoneDegraded;
    const bool repeat = w.repeat == Repeat::kRequested && answer->result.target == model_.target;
    if (repeat && switched) w.repeat = Repeat::kDone;
    ++w.requests[answer->request.value() - 1].replies;
    Log("  request " + ToString(answer->request) + " gets: " +
        std::string(OutcomeName(answer->result.outcome)) + " in " + answer->result.state);
  } else if (const auto* publish = std::get_if<action::PublishEmergencyStop>(&action)) {
    PublishToActuators(*publish);
  } else if (const auto* record = std::get_if<action::Record>(&action)) {
    if (notes_.log) Log("  " + record->message);
  }
}

}  // namespace musher::search
