#pragma once
// Events and machines as JSON and back, without loss: a recording can be replayed years later.
//
//   {"event":"ProcessEnded","now":81234567890,"actuator":3,"pid":4711,"how":"killed by SIGSEGV"}
//
// Keys are the fields' names. Times are nanoseconds of the controller's steady clock, durations
// nanoseconds. A field with its default value is omitted, and a missing field keeps its default, so
// that older recordings can be read; unknown fields are ignored. Enumerations are words. A text
// that is not UTF-8 is written as {"hex":"..."}.
//
// Errors: kCodeParametersInvalid with the place, as in "report.pid: expected a whole number...".

#include <memory>
#include <string>
#include <string_view>

#include "musher/lifecycle/coordinator/coordinator.hpp"

namespace musher::recording {

// An input of Step() with its time.
struct TimedEvent {
  Event event;
  Time now{};

  friend bool operator==(const TimedEvent&, const TimedEvent&) = default;
};

// The text of a machine's config.
struct ConfigText {
  std::string file;
  std::string hash;  // MachineConfig::hash
  std::string text;  // empty: a config that was never written

  friend bool operator==(const ConfigText&, const ConfigText&) = default;
};

// A machine between two events.
struct MachineSnapshot {
  std::string config_hash;  // of its config
  Machine machine;

  friend bool operator==(const MachineSnapshot&, const MachineSnapshot&) = default;
};
using SnapshotPtr = std::shared_ptr<const MachineSnapshot>;

std::string EncodeEvent(const Event& event, Time now);
Result<TimedEvent> DecodeEvent(std::string_view text);

std::string EncodeSnapshot(const MachineSnapshot& snapshot);
Result<MachineSnapshot> DecodeSnapshot(std::string_view text);

std::string EncodeConfig(const ConfigText& config);
Result<ConfigText> DecodeConfig(std::string_view text);

}  // namespace musher::recording
