#pragma once
// Untrusted reports and commands, made from the fuzzer's bytes: correct values, values near their
// limits, or any value. They pass through their messages, as samples from the wire do.

#include "musher/lifecycle/actuator/actuator_core.hpp"
#include "musher/test/fuzz/fuzz.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::fuzz {

// A built-in state, `own` (a state that only this machine has), or any text.
inline State AnyState(Input& input, const State& own = State()) {
  const auto& states = BuiltInStates();
  const std::size_t index = input.Below(states.size() + 2);
  if (index < states.size()) return State(states[index]);
  return index == states.size() ? own : State(input.Text());
}

inline std::int64_t AnyTime(Input& input, Time now) {
  return static_cast<std::int64_t>(
      input.Number(static_cast<std::uint64_t>(transport::ToNanoseconds(now)), INT64_MAX));
}

// `truth`, with some of its fields replaced.
inline ActuatorReport AnyReport(Input& input, const ActuatorReport& truth, Time now) {
  msg::ActuatorStatus status = transport::ToMessage("a", truth);
  status.stamp_ns = transport::ToNanoseconds(now);
  const auto changes = input.Take<std::uint16_t>();
  if ((changes & 1) != 0) status.state = AnyState(input);
  if ((changes & 2) != 0) status.target = AnyState(input);
  if ((changes & 4) != 0)
    status.busy_number = input.Number(truth.number.value(), kLastNumber.value());
  if ((changes & 8) != 0) status.epoch = input.Number(truth.epoch.value(), kLastEpoch.value());
  if ((changes & 16) != 0) status.number = input.Number(truth.number.value(), kLastNumber.value());
  if ((changes & 32) != 0)
    status.outcome_number = input.Number(truth.number.value(), kLastNumber.value());
  if ((changes & 64) != 0) status.outcome_code = input.Take<std::int32_t>();
  if ((changes & 128) != 0) status.outcome_message = input.Text();
  if ((changes & 256) != 0)
    status.incarnation = input.Number(truth.incarnation.value(), UINT64_MAX - 1);
  if ((changes & 512) != 0) status.pid = input.Take<std::int32_t>();
  if ((changes & 1024) != 0) status.host = input.Text();
  if ((changes & 2048) != 0) status.config_hash = input.Text();
  if ((changes & 4096) != 0) status.detached = input.Bool();
  if ((changes & 8192) != 0) status.emergency_stop = input.Number(truth.emergency_stop.value(), 1);
  if ((changes & 16384) != 0) status.stamp_ns = AnyTime(input, now);
  return transport::FromMessage(status);
}

// `truth`, with some of its fields replaced.
inline SwitchCommand AnyCommand(Input& input, const ActuatorReport& truth, Time now,
                                const State& own) {
  SwitchCommand command;
  command.epoch = truth.epoch;
  command.number = truth.number + 1;
  command.target = AnyState(input, own);
  command.budget = Milliseconds(100);
  command.status_stamp = now;
  command.incarnation = truth.incarnation;
  const std::uint8_t changes = input.Byte();
  if ((changes & 1) != 0)
    command.epoch = Epoch(input.Number(truth.epoch.value(), kLastEpoch.value()));
  if ((changes & 2) != 0)
    command.number = CommandNumber(input.Number(truth.number.value(), kLastNumber.value()));
  if ((changes & 4) != 0) command.budget = Duration(AnyTime(input, now));
  if ((changes & 8) != 0) command.status_stamp = transport::FromNanoseconds(AnyTime(input, now));
  if ((changes & 16) != 0) command.since_status = Duration(AnyTime(input, now));
  if ((changes & 32) != 0)
    command.incarnation = Incarnation(input.Number(truth.incarnation.value(), 1));
  if ((changes & 64) != 0) command.detached = input.Bool();
  return command;
}

}  // namespace musher::fuzz
