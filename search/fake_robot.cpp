#include "musher/search/fake_robot.hpp"

#include <utility>

namespace musher::search {

void FakeRobot::Feed(const Event& event) {
  queue_.push_back(event);
  NoteChild(event);
  if (handling_) return;
  handling_ = true;
  while (!queue_.empty()) {
    const Event next = std::move(queue_.front());
    queue_.pop_front();
    StepController(next);
  }
  handling_ = false;
}

// As the shell stores them.
void FakeRobot::NoteChild(const Event& event) {
  auto& children = controller_.disk.children;
  if (const auto* started = std::get_if<event::ProcessStarted>(&event)) {
    children[started->actuator] = started->pid;
  } else if (const auto* ended = std::get_if<event::ProcessEnded>(&event)) {
    const auto child = children.find(ended->actuator);
    if (child != children.end() && child->second == ended->pid) children.erase(child);
  }
}

void FakeRobot::BeginController(bool by_hand, bool restarted, bool supervised, bool at_boot) {
  if (at_boot) controller_.disk.children.clear();
  PerActuator<bool> running;
  PerActuator<std::int32_t> processes;
  PerActuator<bool> ended;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const FakeActuator& actuator = Actuator(i);
    running.push_back(actuator.alive);
    processes.push_back(actuator.alive ? actuator.pid() : 0);
    ended.push_back(!actuator.alive && controller_.disk.children.contains(i));
  }
  const Disk& disk = controller_.disk;
  event::Begin begin{by_hand, disk.epoch, running, "here", disk.stops, processes};
  begin.policy = disk.policy;
  begin.stop_intent = disk.stop_intent;
  begin.restarted = restarted;
  begin.remote = disk.remote;
  begin.actuators = disk.actuators;
  begin.supervised = supervised;
  begin.at_boot = at_boot;
  begin.ended = ended;
  std::erase_if(controller_.disk.children,
                [this](const auto& child) { return !Actuator(child.first).alive; });
  Feed(begin);
}

ActuatorReport FakeRobot::Report(ActuatorIndex i) {
  FakeActuator& actuator = Actuator(i);
  ActuatorReport report = actuator.core.report;
  report.stamp = controller_.now + Duration(++actuator.reports);
  return report;
}

void FakeRobot::FeedExit(const event::ProcessEnded& end) {
  const ActuatorProcess& process = controller_.machine.actuators[end.actuator].process;
  const bool is_child = process.launch != Launch::kFoundRunning;
  if (process.pid == end.pid && is_child) return Feed(end);
  // The kernel says how a process has exited only to the one that has started it.
  if (process.pid == end.pid)
    return Feed(event::ProcessEnded{end.actuator, end.pid, false, "exit code unknown"});
  const Incarnation incarnation(static_cast<std::uint64_t>(end.pid));
  Feed(event::Vanished{end.actuator, incarnation, true, "its process ended"});
}

void FakeRobot::Deliver(const Message& message, bool announced) {
  const FakeActuator& to = Actuator(message.to);
  const Sender sender = message.sender;
  if (!to.alive || !to.visible) return;
  if (announced) {
    StepActuator(message.to, actuator_event::ControllerHeartbeatReceived{sender, message.epoch});
  }
  if (const auto* command = std::get_if<SwitchCommand>(&message.what)) {
    const RequestToken token = TokenOf(sender, command->number, false);
    StepActuator(message.to, actuator_event::SwitchArrived{token, *command, sender});
  } else {
    const QueryCommand& query = std::get<QueryCommand>(message.what);
    const RequestToken token = TokenOf(sender, query.number, true);
    StepActuator(message.to, actuator_event::QueryArrived{token, query, sender});
  }
}

void FakeRobot::Apply(const Action& action) {
  const auto send = [this](ActuatorIndex to, const auto& command) {
    Send({to, controller_.sender(), controller_.machine.epoch, command});
  };
  const auto save = [this](Stored what, SaveNumber number, auto Disk::*place, const auto& value) {
    Save(what, number, [place, value](Disk& disk) { disk.*place = value; });
  };
  if (const auto* command = std::get_if<action::SendSwitch>(&action)) {
    send(command->actuator, command->command);
  } else if (const auto* query = std::get_if<action::SendQuery>(&action)) {
    send(query->actuator, query->command);
  } else if (std::holds_alternative<action::FindProcesses>(action)) {
    event::ProcessesFound found;
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      found.processes.push_back(Actuator(i).alive ? Actuator(i).pid() : 0);
    }
    Feed(found);
  } else if (const auto* epoch = std::get_if<action::SaveEpoch>(&action)) {
    save(Stored::kEpoch, epoch->save, &Disk::epoch, epoch->epoch);
  } else if (const auto* stops = std::get_if<action::SaveEmergencyStops>(&action)) {
    save(Stored::kEmergencyStops, stops->save, &Disk::stops, stops->stops);
  } else if (const auto* policy = std::get_if<action::SavePolicy>(&action)) {
    save(Stored::kPolicy, policy->save, &Disk::policy, policy->policy);
  } else if (const auto* intent = std::get_if<action::SaveStopIntent>(&action)) {
    save(Stored::kStopIntent, intent->save, &Disk::stop_intent, intent->intended);
  } else if (const auto* remote = std::get_if<action::SaveRemoteActuators>(&action)) {
    save(Stored::kRemoteActuators, remote->save, &Disk::remote, remote->actuators);
  } else if (const auto* stored = std::get_if<action::SaveActuators>(&action)) {
    save(Stored::kActuators, stored->save, &Disk::actuators, stored->actuators);
  } else {
    Do(action);
  }
}

}  // namespace musher::search
