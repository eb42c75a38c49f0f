#include "musher/lifecycle/coordinator.hpp"

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {

void Decision::Settle() {
  if (machine_.phase == Phase::kFenced) return;
  CheckCommands();
  TakeUpOthers();
  CheckSetUpDeadlines();
  CheckRestarts();
  // Each can make the next one possible; the loop ends when all of them wait for an event.
  bool changed = true;
  while (changed) {
    changed = AdvanceSwitch();
    if (machine_.phase == Phase::kStopping) {
      AdvanceStopping();
    } else if (machine_.phase != Phase::kIdle && machine_.phase != Phase::kStopped) {
      changed |= BeginWaiting();
      changed |= StartProcesses();
      changed |= AdvanceStart();
      changed |= SuspendAndResume();
      changed |= BeginFallback();
      changed |= AdvancePolicy();
      // Last: what comes before may take the machine to another state.
      if (!changed) changed = DriveLateOnes();
    }
  }
  NoteHosts();
}

// Numbers the record. A record about the machine also reports a change of its state.
std::uint64_t Decision::Record(action::Record record) {
  record.id = ++machine_.last_record;
  const bool of_machine = record.kind == "machine" || (record.kind == "switch" && !record.actuator);
  if (of_machine && machine_.state != machine_.recorded_state) {
    record.state = machine_.recorded_state = machine_.state;
  }
  Do(record);
  return record.id;
}

std::uint64_t Decision::RecordMachine(std::int32_t code, const std::string& message,
                                      std::uint64_t cause) {
  return Record({"machine", std::nullopt, 0, code, message, 0, cause, {}});
}

std::uint64_t Decision::RecordSwitch(const Switch& s, std::int32_t code, const std::string& message,
                                     std::uint64_t cause) {
  return Record({"switch", s.only, s.number, code, message, 0, cause, {}});
}

std::uint64_t Decision::RecordEnd(const Switch& s, const SwitchResult& result,
                                  const std::string& message, std::uint64_t cause) {
  action::Record record{"switch", s.only, s.number, result.code, message, 0, cause, {}};
  record.of_switch = {s.target, result.outcome, result.state};
  return Record(record);
}

std::uint64_t Decision::RecordActuator(std::size_t i, std::int32_t code, const std::string& message,
                                       std::uint64_t cause) {
  const std::uint64_t number = Of(i).command ? Of(i).command->number : 0;
  return Record({"actuator", i, number, code, message, 0, cause, {}});
}

std::uint64_t Decision::RecordProcess(std::size_t i, std::int32_t code, const std::string& message,
                                      std::uint64_t cause) {
  return Record({"process", i, 0, code, message, 0, cause, {}});
}

void Decision::Degrade(std::size_t i, std::int32_t code, const std::string& message,
                       std::uint64_t cause) {
  const Error fault{code, message};
  if (Of(i).fault == fault) return;
  Of(i).fault = fault;
  Of(i).cause = RecordActuator(i, code, ConfigOf(i).name + " is degraded: " + message, cause);
}

std::vector<Action> Step(const MachineConfig& config, Machine& machine, const Event& event,
                         Time now) {
  Decision decision(config, machine, now);
  if (machine.phase == Phase::kFenced) {
    decision.Decline(event);
  } else {
    std::visit([&](const auto& e) { decision.On(e); }, event);
    decision.Settle();
  }
  return std::move(decision).Take();
}

std::optional<Time> NextDeadlineOf(const ActuatorRecord& record) {
  std::optional<Time> next;
  const auto consider = [&](Time when) { next = next ? std::min(*next, when) : when; };
  if (record.command) consider(record.command->deadline);
  if (record.take_control_again) consider(*record.take_control_again);
  if (record.set_up_by && record.presence != Presence::kPresent) consider(*record.set_up_by);
  for (const auto& when : {record.restart_at, record.healthy_at, record.terminate_at,
                           record.kill_at, record.free_by}) {
    if (when) consider(*when);
  }
  return next;
}

std::optional<Time> NextDeadline(const MachineConfig& config, const Machine& machine) {
  std::optional<Time> next;
  if (machine.phase == Phase::kFenced || machine.phase == Phase::kStopped) return next;
  const auto consider = [&](std::optional<Time> when) {
    if (when) next = next ? std::min(*next, *when) : *when;
  };
  for (const ActuatorRecord& record : machine.actuators) consider(NextDeadlineOf(record));
  if (machine.phase == Phase::kStopping && machine.stopping) {
    const Stopping& stopping = *machine.stopping;
    consider(stopping.intent_by);
    if (!stopping.terminated) consider(stopping.terminate_at);
    consider(stopping.killed ? stopping.give_up_at : stopping.kill_at);
  }
  if (machine.waiting) consider(machine.waiting->until);
  consider(NextPowerDeadline(machine));
  if (config.clock == ClockSource::kSteady) consider(NextPolicyDeadline(config, machine));
  return next;
}

}  // namespace musher
