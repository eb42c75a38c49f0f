#include "musher/controller/journal/input_recorder.hpp"

#include <algorithm>
#include <utility>

namespace musher::recording {
namespace {

// A snapshot is about as long as some inputs for each actuator; so snapshots take a small part.
constexpr std::size_t kInputsForSnapshot = 1000;
constexpr std::size_t kInputsForActuator = 30;

}  // namespace

InputRecorder::InputRecorder(JournalSink& sink, const MachineConfig& config)
    : sink_(sink), config_(config) {}

void InputRecorder::Begin(std::int64_t wall_ns, std::string config_text) {
  config_text_ = std::move(config_text);
  sink_.Append(JournalInput{wall_ns, ConfigText{config_.file, config_.hash, config_text_}});
}

void InputRecorder::Note(std::int64_t wall_ns, const Machine& before, const Event& event,
                         Time now) {
  if (sink_.WantsSnapshot() && before.phase != Phase::kIdle) {
    Begin(wall_ns, std::move(config_text_));  // it may also be lost
    TakeSnapshot(wall_ns, before);
  } else if (since_snapshot_ >=
             std::max(kInputsForSnapshot, kInputsForActuator * before.actuators.size())) {
    TakeSnapshot(wall_ns, before);
  }
  sink_.Append(JournalInput{wall_ns, TimedEvent{event, now}});
  ++since_snapshot_;
}

void InputRecorder::TakeSnapshot(std::int64_t wall_ns, const Machine& machine) {
  sink_.Append(JournalInput{
      wall_ns, std::make_shared<const MachineSnapshot>(MachineSnapshot{config_.hash, machine})});
  since_snapshot_ = 0;
}

}  // namespace musher::recording
