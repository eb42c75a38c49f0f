#include "musher/lifecycle/step/step_part.hpp"

namespace musher {

// Numbers the record. A record about the machine also reports a change of its state.
RecordId StepPart::Record(action::Record record) {
  record.id = ++machine_.last_record;
  const bool of_machine = record.kind == "machine" || (record.kind == "switch" && !record.actuator);
  if (of_machine && machine_.state != machine_.recorded_state) {
    record.state = machine_.recorded_state = machine_.state;
  }
  Do(record);
  return record.id;
}

RecordId StepPart::RecordMachine(std::int32_t code, const std::string& message, RecordId cause) {
  return Record({"machine", std::nullopt, 0, code, message, 0, cause, {}});
}

RecordId StepPart::RecordEnd(const Switch& s, const SwitchResult& result,
                             const std::string& message, RecordId cause) {
  action::Record record{"switch", s.only, s.number, result.code, message, 0, cause, {}};
  record.of_switch = {s.target, result.outcome, result.state};
  return Record(record);
}

RecordId StepPart::RecordActuator(std::size_t i, std::int32_t code, const std::string& message,
                                  RecordId cause) {
  const CommandNumber number = Of(i).command ? Of(i).command->number : 0;
  return Record({"actuator", i, number, code, message, 0, cause, {}});
}

RecordId StepPart::RecordProcess(std::size_t i, std::int32_t code, const std::string& message,
                                 RecordId cause) {
  return Record({"process", i, 0, code, message, 0, cause, {}});
}

RecordId StepPart::RecordPolicy(std::int32_t code, const std::string& message, RecordId cause) {
  return Record({"policy", std::nullopt, 0, code, message, 0, cause, {}});
}

void StepPart::Degrade(std::size_t i, std::int32_t code, const std::string& message,
                       RecordId cause) {
  const Error fault{code, message};
  if (Of(i).fault == fault) return;
  Of(i).fault = fault;
  Of(i).cause = RecordActuator(i, code, ConfigOf(i).name + " is degraded: " + message, cause);
}

void StepPart::FallBack(std::size_t i) {
  const State& on_lost = ConfigOf(i).on_lost;
  if (on_lost.empty() || machine_.phase != Phase::kRunning) return;
  if (!machine_.fallback || *config_.RankOf(on_lost) < *config_.RankOf(*machine_.fallback)) {
    machine_.fallback = on_lost;
    machine_.fallback_cause = Of(i).cause;
  }
}

}  // namespace musher
