#pragma once
// The ids of states and events inside a machine. Names are used at its interfaces: registration,
// logs, the network. Ids count from 0 in the order of registration.

#include <cstddef>
#include <cstdint>

namespace musher::fsm {

enum class StateId : std::uint16_t {};
enum class EventId : std::uint16_t {};

inline constexpr StateId kNoState{0xffff};
inline constexpr EventId kNoEvent{0xffff};

constexpr std::size_t Index(StateId id) {
  return static_cast<std::size_t>(id);
}
constexpr std::size_t Index(EventId id) {
  return static_cast<std::size_t>(id);
}

}  // namespace musher::fsm
