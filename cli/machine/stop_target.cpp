#include "musher/cli/machine/stop_target.hpp"

namespace musher::cli {

MachineIdentity MachineToStop(const StopBelief& belief) {
  const MachineIdentity here = belief.led.value_or(MachineIdentity{});
  if (!belief.word.empty()) {
    const bool by_id = here.name != belief.word && BeginsIdOf(here, belief.word);
    return by_id ? here : MachineIdentity{belief.word, ""};
  }
  if (belief.led) return here;
  if (belief.runs_here) return {};
  return belief.of_files.value_or(MachineIdentity{});
}

std::optional<MachineIdentity> MachineByFiles(const std::string& word,
                                              const std::vector<MachineHere>& machines) {
  std::optional<MachineIdentity> found;
  for (const MachineHere& one : machines) {
    if (one.identity.name == word) return std::nullopt;
    if (!BeginsIdOf(one.identity, word)) continue;
    if (found && !SameMachine(*found, one.identity)) return std::nullopt;
    found = one.identity;
  }
  return found;
}

StopReach ReachOf(const MachineIdentity& machine, const std::string& word,
                  const std::vector<MachineHere>& machines,
                  const std::vector<std::string>& running_here) {
  StopReach reach;
  const bool named = !machine.name.empty() || !machine.id.empty();
  const bool by_id = !word.empty() && machine.id.empty();
  for (const MachineHere& one : machines) {
    const bool may_be = by_id && one.identity.id.empty();
    if (!one.lan || (!may_be && !SameMachine(one.identity, machine))) continue;
    if (!named && !running_here.empty() && !one.HasOneOf(running_here)) continue;
    reach.lan = true;
    if (reach.interfaces.empty()) reach.interfaces = one.interfaces;
  }
  return reach;
}

}  // namespace musher::cli
