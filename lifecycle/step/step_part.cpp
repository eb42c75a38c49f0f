#include "musher/lifecycle/step/step_part.hpp"

#include <utility>

namespace musher {
namespace {

action::Record Filled(const char* kind, std::int32_t code, const RecordText& text, RecordId cause) {
  action::Record record;
  record.kind = kind;
  record.code = code;
  record.message = text.message;
  record.event = text.event;
  record.arguments = text.arguments;
  record.cause = cause;
  return record;
}

}  // namespace

// Numbers the record. A record about the machine also reports a change of its state.
RecordId StepPart::Record(action::Record record) {
  record.id = ++machine_.last_record;
  const bool of_machine = record.kind == "machine" || (record.kind == "switch" && !record.actuator);
  if (of_machine && machine_.state != machine_.recorded_state) {
    record.state = machine_.recorded_state = machine_.state;
  }
  const RecordId id = record.id;
  Do(std::move(record));
  return id;
}

RecordId StepPart::RecordMachine(std::int32_t code, const RecordText& text, RecordId cause) {
  return Record(Filled("machine", code, text, cause));
}

RecordId StepPart::RecordSwitch(std::optional<ActuatorIndex> only, CommandNumber number,
                                std::int32_t code, const RecordText& text, RecordId cause) {
  action::Record record = Filled("switch", code, text, cause);
  record.actuator = only;
  record.switch_number = number;
  return Record(std::move(record));
}

RecordId StepPart::RecordBegin(const Switch& s, RecordId cause) {
  const std::string only = s.only ? ConfigOf(*s.only).name : "";
  action::Record record =
      Filled("switch", kCodeOk,
             texts::SwitchStarted(s.number, only, s.from, s.target, s.legs.size()), cause);
  record.actuator = s.only;
  record.switch_number = s.number;
  record.of_switch = {s.target, std::nullopt, s.from};
  return Record(std::move(record));
}

RecordId StepPart::RecordEnd(const Switch& s, const SwitchResult& result, RecordId cause) {
  action::Record record = Filled(
      "switch", result.code, texts::SwitchEnded(s.number, result.outcome, result.reason), cause);
  record.actuator = s.only;
  record.switch_number = s.number;
  record.of_switch = {s.target, result.outcome, result.state};
  return Record(std::move(record));
}

RecordId StepPart::RecordActuator(ActuatorIndex i, std::int32_t code, const RecordText& text,
                                  RecordId cause) {
  action::Record record = Filled("actuator", code, text, cause);
  record.actuator = i;
  if (Of(i).command) record.switch_number = Of(i).command->number;
  return Record(std::move(record));
}

RecordId StepPart::RecordProcess(ActuatorIndex i, std::int32_t code, const RecordText& text,
                                 RecordId cause) {
  action::Record record = Filled("process", code, text, cause);
  record.actuator = i;
  return Record(std::move(record));
}

RecordId StepPart::RecordPolicy(std::int32_t code, const RecordText& text, RecordId cause) {
  return Record(Filled("policy", code, text, cause));
}

// The same sentence with another event is the same fault. That another controller has the actuator
// says more than that it refuses a command.
void StepPart::Degrade(ActuatorIndex i, std::int32_t code, const RecordText& text, RecordId cause) {
  const auto& known = Of(i).fault;
  if (known && known->code == code && known->message == text.message) return;
  const bool says_less = known && known->event == EventName::kControlledByAnother &&
                         text.event != known->event && code == kCodePermissionDenied;
  if (says_less) return;
  Of(i).fault = ActuatorFault{code, text.message, text.event};
  Of(i).cause = RecordActuator(i, code, texts::Degraded(ConfigOf(i).name, text), cause);
}

bool StepPart::IsCheckDue(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  const FailedChecks& failed = known.failed_checks;
  const bool at_rest = known.state() == kDeActive || known.state() == kLowPower;
  const bool stopped = machine_.emergency.stop || known.report.emergency_stop != 0;
  const bool follows = known.checked && !known.fault && !known.held && !known.suspended;
  std::optional<RecordText> blocker;
  return follows && at_rest && !stopped && IsFree(i) && failed.count > 0 &&
         (!failed.at || now_ >= *failed.at) && PartialFaultOf(known) && NeedsMet(i, blocker);
}

void StepPart::FallBack(ActuatorIndex i) {
  const State& on_lost = ConfigOf(i).on_lost;
  if (on_lost.empty() || machine_.phase != Phase::kRunning) return;
  if (!machine_.fallback.target ||
      *config_.RankOf(on_lost) < *config_.RankOf(*machine_.fallback.target)) {
    machine_.fallback.target = on_lost;
    machine_.fallback.cause = Of(i).cause;
  }
}

}  // namespace musher
