#pragma once
// When an application begins. Nothing moves because a process was restarted: its controller brings
// a restarted actuator back to Active, and perhaps no person is looking.
//
//   a tree           its first node moves: it rests in Active until a command (kOnCommand)
//   a state machine  has a start state that stands and waits for a command, so it may begin in
//                    Active (kAtActive); one whose start state moves begins on command
//   skills           begin by a goal
//
// The command comes from a person, and counts until the process ends: START by
// `musher behavior NAME --send START`, a command or a service of its own, Load() or Restart().
// docs/application.md has what each application of Musher does.

#include <cstdint>

namespace musher {

enum class Begin : std::uint8_t {
  kOnCommand,  // it stands in Active until then, also after a restart of its process
  kAtActive,   // by itself: it does not move then, or a key that a person has set allows it
};

// The command by which an application begins.
inline constexpr const char* kStartCommand = "START";

}  // namespace musher
