#pragma once
// Which machine a controller, a command, a stop or a request belongs to. Another machine in the
// same namespace and domain never fences, drives or ends anything of this one.

#include <cstddef>
#include <string>
#include <string_view>

namespace musher {

// Every part may be empty: not known.
struct MachineIdentity {
  std::string name;  // from the config
  std::string id;    // a UUID, made at the machine's first start, kept in its state folder

  friend bool operator==(const MachineIdentity&, const MachineIdentity&) = default;
};

// Whether both are one machine, as far as is known. A peer of an older version sends no id: its
// name counts.
inline bool SameMachine(const MachineIdentity& a, const MachineIdentity& b) {
  const bool same_name = a.name.empty() || b.name.empty() || a.name == b.name;
  const bool same_id = a.id.empty() || b.id.empty() || a.id == b.id;
  return same_name && same_id;
}

// Whether `word` is the beginning of its id, as a person types it.
inline bool BeginsIdOf(const MachineIdentity& machine, std::string_view word) {
  constexpr std::size_t kShortest = 4;
  return word.size() >= kShortest && machine.id.starts_with(word);
}

// "robot", "robot (id 5982c7ee)": two machines may have the same name.
inline std::string MachineText(const MachineIdentity& machine) {
  if (machine.id.empty()) return machine.name;
  return machine.name + " (id " + machine.id.substr(0, 8) + ")";
}

}  // namespace musher
