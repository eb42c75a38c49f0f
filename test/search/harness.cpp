#include "musher/test/search/harness.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/test/search/rules.hpp"

namespace musher::search {
namespace {

// How far each actuator's clock is ahead of its stamps, which differ while time stands still.
constexpr Duration kClockAhead = Milliseconds(1);
constexpr StopId kStopId = 5;

// The token of a request holds its number, its kind and its sender.
RequestToken TokenOf(CommandNumber number, bool query, Sender sender) {
  return RequestToken(number.value() << 8 | static_cast<std::uint64_t>(query) << 7 |
                      sender.value());
}
Sender SenderOf(RequestToken token) {
  return Sender(token.value() & 127);
}

}  // namespace

bool FromActuator(const Late& late) {
  return std::holds_alternative<event::Replied>(late) ||
         std::holds_alternative<event::StatusSeen>(late);
}

void Harness::Log(const std::string& sentence) {
  if (notes_.log) notes_.scenario.push_back(sentence);
}

ActuatorReport Harness::Report(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  ActuatorReport report = actuator.core.report;
  report.stamp = world_.now + Duration(++actuator.reports);
  return report;
}

// Events are handled one after the other, as in the controller's shell.
void Harness::Feed(const Event& event) {
  queue_.push_back(event);
  if (handling_) return;
  handling_ = true;
  while (!queue_.empty()) {
    const Event next = std::move(queue_.front());
    queue_.pop_front();
    Machine& machine = world_.machine;
    // The controller has ended, or is about to and can only refuse.
    const bool requested = std::holds_alternative<event::SetStateRequested>(next);
    if (machine.phase == Phase::kStopped && !requested) continue;
    const bool starting = machine.current && machine.current->purpose == Purpose::kStartUpActivate;
    const Before before{machine.state, machine.phase, machine.emergency.stop.has_value(), starting};
    const auto actions = model_.rules.controller(config_, machine, next, world_.now);
    for (const Action& action : actions) Apply(action);
    CheckStep(model_, world_, before, notes_);
  }
  handling_ = false;
}

void Harness::RequestSwitch(const State& target) {
  world_.requests.push_back({target});
  Log("a caller requests " + target);
  Feed(event::SetStateRequested{RequestId(world_.requests.size()), target, std::nullopt});
}

void Harness::BeginController(bool by_hand) {
  PerActuator<bool> running;
  for (const SimActuator& actuator : world_.actuators) running.push_back(actuator.alive);
  Feed(event::Begin{by_hand, world_.epoch_on_disk, running, "here", world_.stops_on_disk});
}

void Harness::RestartController() {
  World& w = world_;
  ++w.generation;
  if (w.repeat == Repeat::kDone) w.repeat = Repeat::kRequested;
  w.machine = MakeMachine(config_);
  w.outbox.clear();
  for (Request& request : w.requests) request.abandoned |= request.replies == 0;
  w.stop_seen_due = w.stopped && !w.released && w.stops_on_disk.engaged.empty();
  for (SimActuator& actuator : w.actuators) {
    actuator.replies.clear();
    actuator.end.reset();
    actuator.status_due = actuator.alive;  // latched for the next controller
    std::erase_if(actuator.late, FromActuator);
  }
  BeginController(false);
}

void Harness::FeedReply(ActuatorIndex i) {
  auto& replies = world_.actuators[i].replies;
  const event::Replied reply = std::move(replies.front());
  replies.erase(replies.begin());
  Feed(reply);
}

void Harness::FeedStatus(ActuatorIndex i) {
  world_.actuators[i].status_due = false;
  Feed(event::StatusSeen{i, Report(i)});
}

void Harness::FeedEnd(ActuatorIndex i) {
  const bool clean = *std::exchange(world_.actuators[i].end, std::nullopt);
  const std::int32_t pid = world_.actuators[i].core.report.pid;
  const std::string how = clean ? "exit code 0" : "killed";
  if (world_.machine.actuators[i].process.pid == pid) {
    return Feed(event::ProcessEnded{i, pid, clean, how});
  }
  Feed(event::Vanished{i, Incarnation(static_cast<std::uint64_t>(pid)), true, "its process ended"});
}

void Harness::StartActuator(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  SimActuator next;
  next.late = std::move(actuator.late);
  next.processes = actuator.processes + 1;
  actuator = std::move(next);
  actuator.alive = true;
  actuator.core.report.pid = actuator.processes;
  actuator.core.report.incarnation =
      Incarnation(static_cast<std::uint64_t>(actuator.core.report.pid));
  actuator.core.report.host = "here";
  StepActuator(i, actuator_event::Started{});
  if (world_.stopped && !world_.released) ReceiveStop(i);  // its topic is latched
}

// A process that has ended, or is not set up, receives nothing.
void Harness::Deliver(const Message& message, bool held_back, bool introduced) {
  const SimActuator& actuator = world_.actuators[message.to];
  if (!actuator.alive || !actuator.visible) return;
  if (introduced) {
    StepActuator(message.to,
                 actuator_event::ControllerHeartbeatReceived{message.sender, message.epoch});
  }
  if (const auto* command = std::get_if<SwitchCommand>(&message.what)) {
    const RequestToken token = TokenOf(command->number, false, message.sender);
    StepActuator(message.to, actuator_event::SwitchArrived{token, *command, message.sender},
                 held_back);
  } else {
    const QueryCommand& query = std::get<QueryCommand>(message.what);
    const RequestToken token = TokenOf(query.number, true, message.sender);
    StepActuator(message.to, actuator_event::QueryArrived{token, query, message.sender});
  }
}

// The end of a callback switches the output on, towards a state that is as active or more, or off;
// a self-check switches nothing.
void Harness::EndCallback(ActuatorIndex i, std::int32_t code, const std::string& text) {
  SimActuator& actuator = world_.actuators[i];
  actuator.work = Work::kNone;
  const ActuatorReport& report = actuator.core.report;
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

void Harness::Crash(ActuatorIndex i) {
  SimActuator& actuator = world_.actuators[i];
  actuator.status_due = false;
  EndProcess(i, false);
  FeedEnd(i);
}

void Harness::EndProcess(ActuatorIndex i, bool clean) {
  SimActuator& actuator = world_.actuators[i];
  actuator.alive = actuator.visible = false;
  actuator.work = Work::kNone;
  actuator.end = clean;
}

void Harness::EngageStop(std::optional<ActuatorIndex> except) {
  world_.stopped = world_.stop_seen_due = true;
  for (const ActuatorIndex i : kIndices) {
    if (i != except) ReceiveStop(i);
  }
}

void Harness::StepActuator(ActuatorIndex i, const ActuatorEvent& event, bool held_back) {
  SimActuator& actuator = world_.actuators[i];
  if (!actuator.alive) return;
  // Of the command that this event may begin.
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
      actuator.work = held_back ? Work::kOverdue : Work::kRunning;
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
    Apply(i, action);
  }
  CheckStopped(model_, world_, i, before, notes_);
}

void Harness::Apply(ActuatorIndex i, const ActuatorAction& action) {
  SimActuator& actuator = world_.actuators[i];
  if (std::holds_alternative<actuator_action::RunEmergencyStop>(action)) actuator.energised = false;
  if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
    Log("  " + Name(i) + " begins " + run->target);
  } else if (std::holds_alternative<actuator_action::RequestStop>(action)) {
    actuator.stop_requested = true;
  } else if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
    if (SenderOf(answer->token) != Controller()) return;  // its caller has ended
    actuator.replies.push_back({i, CommandNumber(answer->token.value() >> 8),
                                (answer->token.value() >> 7 & 1) != 0, answer->verdict,
                                answer->code, answer->message, Report(i)});
  } else if (std::holds_alternative<actuator_action::PublishStatus>(action) ||
             std::holds_alternative<actuator_action::RunEmergencyStop>(action)) {
    actuator.status_due = true;
  } else if (std::holds_alternative<actuator_action::BecomeVisible>(action)) {
    actuator.visible = true;
  } else if (const auto* finish = std::get_if<actuator_action::Finish>(&action)) {
    EndProcess(i, finish->code == kCodeOk);
  }
}

void Harness::Send(ActuatorIndex i, std::variant<SwitchCommand, QueryCommand> what) {
  world_.outbox.push_back({i, Controller(), world_.machine.epoch, std::move(what)});
}

void Harness::Apply(const Action& action) {
  World& w = world_;
  if (const auto* send = std::get_if<action::SendSwitch>(&action)) {
    CheckCommand(model_, w, *send, notes_);
    Send(send->actuator, send->command);
  } else if (const auto* query = std::get_if<action::SendQuery>(&action)) {
    Send(query->actuator, query->command);
  } else if (const auto* start = std::get_if<action::StartProcess>(&action)) {
    StartActuator(start->actuator);
    Feed(event::ProcessStarted{start->actuator, w.actuators[start->actuator].core.report.pid});
  } else if (std::holds_alternative<action::FindProcesses>(action)) {
    event::ProcessesFound found;
    for (const SimActuator& actuator : w.actuators) {
      found.processes.push_back(actuator.alive ? actuator.core.report.pid : 0);
    }
    Feed(found);
  } else if (const auto* signal = std::get_if<action::SignalProcess>(&action)) {
    const SimActuator& actuator = w.actuators[signal->actuator];
    if (actuator.alive && actuator.core.report.pid == signal->pid)
      EndProcess(signal->actuator, false);
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
    for (const ActuatorIndex i : kIndices) {
      if (!publish->engaged) {
        StepActuator(i, actuator_event::EmergencyStopReceived{kStopId, false, Controller()});
        continue;
      }
      // An actuator that receives the stop late receives all of it late.
      const auto& late = w.actuators[i].late;
      const bool later = std::any_of(late.begin(), late.end(), [](const Late& l) {
        return std::holds_alternative<StopMessage>(l);
      });
      if (!later) ReceiveStop(i);
    }
  } else if (const auto* stops = std::get_if<action::SaveEmergencyStops>(&action)) {
    w.stops_on_disk = stops->stops;
    Feed(event::SaveEnded{Stored::kEmergencyStops, stops->save, true, {}});
  } else if (const auto* saved = std::get_if<action::SaveEpoch>(&action)) {
    w.epoch_on_disk = saved->epoch;
    Feed(event::SaveEnded{Stored::kEpoch, saved->save, true, {}});
  } else if (const auto* intent = std::get_if<action::SaveStopIntent>(&action)) {
    Feed(event::SaveEnded{Stored::kStopIntent, intent->save, true, {}});
  } else if (const auto* remote = std::get_if<action::SaveRemoteActuators>(&action)) {
    Feed(event::SaveEnded{Stored::kRemoteActuators, remote->save, true, {}});
  } else if (const auto* record = std::get_if<action::Record>(&action)) {
    if (notes_.log) Log("  " + record->message);
  }
}

}  // namespace musher::search
