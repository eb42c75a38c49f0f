#include "musher/test/search/harness.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/flow.hpp"
#include "musher/test/search/rules.hpp"

namespace musher::search {
namespace {

// Each actuator's clock is so much ahead of the stamps that it gives while time stands still.
constexpr Duration kClockAhead = Milliseconds(1);
constexpr std::uint64_t kStopId = 5;

// The token of a request tells what it was and whose.
RequestToken TokenOf(std::uint64_t number, bool ask, Sender sender) {
  return number << 8 | static_cast<RequestToken>(ask) << 7 | sender;
}
Sender SenderOf(RequestToken token) {
  return token & 127;
}

}  // namespace

bool FromActuator(const Late& late) {
  return std::holds_alternative<event::Replied>(late) ||
         std::holds_alternative<event::StatusSeen>(late);
}

void Harness::Say(const std::string& sentence) {
  if (notes_.tell) notes_.scenario.push_back(sentence);
}

ActuatorReport Harness::Report(std::size_t i) {
  Actor& actor = world_.actors[i];
  ActuatorReport report = actor.core.report;
  report.stamp = world_.now + Duration(++actor.reports);
  return report;
}

// Events are handled one after the other, as in the controller's shell.
void Harness::Tell(const Event& event) {
  queue_.push_back(event);
  if (handling_) return;
  handling_ = true;
  while (!queue_.empty()) {
    const Event next = std::move(queue_.front());
    queue_.pop_front();
    Machine& machine = world_.machine;
    // The controller has ended, or is about to and can only refuse.
    const bool asked = std::holds_alternative<event::SetStateRequested>(next);
    if (machine.phase == Phase::kStopped && !asked) continue;
    const bool starting = machine.current && machine.current->purpose == Purpose::kStartUpActivate;
    const Before before{machine.state, machine.phase, machine.emergency_stop.has_value(), starting};
    const auto actions = model_.rules.controller(config_, machine, next, world_.now);
    for (const Action& action : actions) Do(action);
    CheckStep(model_, world_, before, notes_);
  }
  handling_ = false;
}

void Harness::Ask(const State& target) {
  world_.requests.push_back({target});
  Say("somebody asks for " + target);
  Tell(event::SetStateRequested{world_.requests.size(), target, std::nullopt});
}

void Harness::BeginController(bool by_hand) {
  std::vector<bool> running;
  for (const Actor& actor : world_.actors) running.push_back(actor.alive);
  Tell(event::Begin{by_hand, world_.epoch_on_disk, running, "here", world_.stops_on_disk});
}

void Harness::RestartController() {
  World& w = world_;
  ++w.generation;
  w.machine = MakeMachine(config_);
  w.outbox.clear();
  for (Request& request : w.requests) request.gone |= request.answers == 0;
  w.stop_seen_due = w.stopped && w.stops_on_disk.engaged.empty();
  for (Actor& actor : w.actors) {
    actor.replies.clear();
    actor.end.reset();
    actor.status_due = actor.alive;  // the latch is there for whoever comes
    std::erase_if(actor.late, FromActuator);
  }
  BeginController(false);
}

void Harness::TellReply(std::size_t i) {
  auto& replies = world_.actors[i].replies;
  const event::Replied reply = std::move(replies.front());
  replies.erase(replies.begin());
  Tell(reply);
}

void Harness::TellStatus(std::size_t i) {
  world_.actors[i].status_due = false;
  Tell(event::StatusSeen{i, Report(i)});
}

void Harness::TellEnd(std::size_t i) {
  const bool clean = *std::exchange(world_.actors[i].end, std::nullopt);
  const std::int32_t pid = world_.actors[i].core.report.pid;
  const std::string how = clean ? "exit code 0" : "killed";
  if (world_.machine.actuators[i].process == pid) {
    return Tell(event::ProcessEnded{i, pid, clean, how});
  }
  Tell(event::Vanished{i, static_cast<std::uint64_t>(pid), true, "its process ended"});
}

void Harness::StartActuator(std::size_t i) {
  Actor& actor = world_.actors[i];
  Actor next;
  next.late = std::move(actor.late);
  next.processes = actor.processes + 1;
  actor = std::move(next);
  actor.alive = true;
  actor.core.report.pid = actor.processes;
  actor.core.report.incarnation = static_cast<std::uint64_t>(actor.core.report.pid);
  actor.core.report.host = "here";
  Perform(i, actuator_event::Started{});
  if (world_.stopped) HearStop(i);  // its topic is latched
}

// A process that is not there, or not set up, has nobody who listens.
void Harness::Deliver(const Message& message, bool held_back, bool introduced) {
  const Actor& actor = world_.actors[message.to];
  if (!actor.alive || !actor.visible) return;
  if (introduced) {
    Perform(message.to, actuator_event::ControllerHeard{message.sender, message.epoch});
  }
  if (const auto* command = std::get_if<SwitchCommand>(&message.what)) {
    const RequestToken token = TokenOf(command->number, false, message.sender);
    Perform(message.to, actuator_event::SwitchArrived{token, *command, message.sender}, held_back);
  } else {
    const AskCommand& ask = std::get<AskCommand>(message.what);
    const RequestToken token = TokenOf(ask.number, true, message.sender);
    Perform(message.to, actuator_event::AskArrived{token, ask, message.sender});
  }
}

// Its last instruction switches the output on, on the way up, or off; a check switches nothing.
void Harness::EndCallback(std::size_t i, std::int32_t code, const std::string& text) {
  Actor& actor = world_.actors[i];
  actor.work = Work::kNone;
  const ActuatorReport& report = actor.core.report;
  if (code == kCodeOk && config_.RankOf(report.target)) {
    const bool again = report.target == report.state && report.emergency_stop == 0 &&
                       Rises(config_, kUninitialized, report.target);
    actor.energised = again || Rises(config_, report.state, report.target);
  }
  Perform(i, actuator_event::CallbackEnded{code, text});
}

void Harness::HearStop(std::size_t i) {
  Perform(i, actuator_event::EmergencyStopHeard{kStopId, true, 0});
}

void Harness::Crash(std::size_t i) {
  Actor& actor = world_.actors[i];
  actor.status_due = false;
  EndProcess(i, false);
  TellEnd(i);
}

void Harness::EndProcess(std::size_t i, bool clean) {
  Actor& actor = world_.actors[i];
  actor.alive = actor.visible = false;
  actor.work = Work::kNone;
  actor.end = clean;
}

void Harness::EngageStop(std::optional<std::size_t> but) {
  world_.stopped = world_.stop_seen_due = true;
  for (std::size_t i = 0; i < kActuators; ++i) {
    if (i != but) HearStop(i);
  }
}

void Harness::Perform(std::size_t i, const ActuatorEvent& event, bool held_back) {
  Actor& actor = world_.actors[i];
  if (!actor.alive) return;
  // The command that this may begin.
  std::uint64_t epoch = actor.core.waiting ? actor.core.waiting->command.epoch : 0;
  const auto* arrived = std::get_if<actuator_event::SwitchArrived>(&event);
  if (arrived != nullptr) epoch = arrived->command.epoch;
  const ActuatorReport before = actor.core.report;
  const auto actions =
      model_.rules.actuator(config_, i, actor.core, event, world_.now + kClockAhead);
  for (const ActuatorAction& action : actions) {
    if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
      const std::uint64_t number = actor.core.report.busy_number;
      CheckBeginning(model_, world_, i, run->target, epoch, number, notes_);
      actor.begun = std::max(actor.begun, number);
      actor.work = held_back ? Work::kOverdue : Work::kRunning;
      actor.stop_requested = false;
    }
    if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
      if (answer->code != kCodePermissionDenied) actor.epoch = std::max(actor.epoch, epoch);
      const auto* ask = std::get_if<actuator_event::AskArrived>(&event);
      if (ask != nullptr && answer->verdict == Verdict::kDone) {
        actor.epoch = std::max(actor.epoch, ask->command.epoch);
        actor.asked = std::max(actor.asked, ask->command.number);
      }
    }
    Do(i, action);
  }
  CheckStopped(model_, world_, i, before, notes_);
}

void Harness::Do(std::size_t i, const ActuatorAction& action) {
  Actor& actor = world_.actors[i];
  if (std::holds_alternative<actuator_action::RunEmergencyStop>(action)) actor.energised = false;
  if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
    Say("  " + Name(i) + " begins " + run->target);
  } else if (std::holds_alternative<actuator_action::RequestStop>(action)) {
    actor.stop_requested = true;
  } else if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
    if (SenderOf(answer->token) != Controller()) return;  // whoever asked is no more
    actor.replies.push_back({i, answer->token >> 8, (answer->token >> 7 & 1) != 0, answer->verdict,
                             answer->code, answer->message, Report(i)});
  } else if (std::holds_alternative<actuator_action::PublishStatus>(action) ||
             std::holds_alternative<actuator_action::RunEmergencyStop>(action)) {
    actor.status_due = true;
  } else if (std::holds_alternative<actuator_action::BecomeVisible>(action)) {
    actor.visible = true;
  } else if (const auto* finish = std::get_if<actuator_action::Finish>(&action)) {
    EndProcess(i, finish->code == kCodeOk);
  }
}

void Harness::Send(std::size_t i, std::variant<SwitchCommand, AskCommand> what) {
  world_.outbox.push_back({i, Controller(), world_.machine.epoch, std::move(what)});
}

void Harness::Do(const Action& action) {
  World& w = world_;
  if (const auto* send = std::get_if<action::SendSwitch>(&action)) {
    CheckCommand(model_, w, *send, notes_);
    const ActuatorRecord& record = w.machine.actuators[send->actuator];
    Send(send->actuator, SwitchCommand{w.machine.epoch, send->number, send->target, send->budget,
                                       record.clock_theirs, w.now - record.clock_ours,
                                       record.report.incarnation, send->apart});
  } else if (const auto* ask = std::get_if<action::SendAsk>(&action)) {
    Send(ask->actuator, AskCommand{w.machine.epoch, ask->number, ask->stop});
  } else if (const auto* start = std::get_if<action::StartProcess>(&action)) {
    StartActuator(start->actuator);
    Tell(event::ProcessStarted{start->actuator, w.actors[start->actuator].core.report.pid});
  } else if (std::holds_alternative<action::FindProcesses>(action)) {
    event::ProcessesFound found;
    for (const Actor& actor : w.actors) {
      found.processes.push_back(actor.alive ? actor.core.report.pid : 0);
    }
    Tell(found);
  } else if (const auto* signal = std::get_if<action::SignalProcess>(&action)) {
    const Actor& actor = w.actors[signal->actuator];
    if (actor.alive && actor.core.report.pid == signal->pid) EndProcess(signal->actuator, false);
  } else if (const auto* answer = std::get_if<action::AnswerSetState>(&action)) {
    CheckAnswer(model_, w, *answer, notes_);
    ++w.requests[answer->request - 1].answers;
    Say("  request " + std::to_string(answer->request) + " is told: " +
        std::string(OutcomeName(answer->result.outcome)) + " in " + answer->result.state);
  } else if (const auto* tell = std::get_if<action::TellEmergencyStop>(&action)) {
    for (std::size_t i = 0; i < kActuators && tell->engaged; ++i) {
      // The one that hears late hears all late.
      const auto& late = w.actors[i].late;
      const bool later = std::any_of(late.begin(), late.end(), [](const Late& l) {
        return std::holds_alternative<StopMessage>(l);
      });
      if (!later) HearStop(i);
    }
  } else if (const auto* stops = std::get_if<action::SaveEmergencyStops>(&action)) {
    w.stops_on_disk = stops->stops;
    Tell(event::SaveEnded{Stored::kEmergencyStops, stops->save, true, {}});
  } else if (const auto* saved = std::get_if<action::SaveEpoch>(&action)) {
    w.epoch_on_disk = saved->epoch;
    Tell(event::SaveEnded{Stored::kEpoch, saved->save, true, {}});
  } else if (const auto* intent = std::get_if<action::SaveStopIntent>(&action)) {
    Tell(event::SaveEnded{Stored::kStopIntent, intent->save, true, {}});
  } else if (const auto* record = std::get_if<action::Record>(&action)) {
    if (notes_.tell) Say("  " + record->message);
  }
}

}  // namespace musher::search
