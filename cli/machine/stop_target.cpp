#include "musher/cli/machine/stop_target.hpp"

#include <algorithm>

namespace musher::cli {
namespace {

// Whether a machine may have an id that begins so: of hexadecimal digits and '-'.
bool MayBeginId(const std::string& word) {
  return BeginsIdOf({"", word}, word) &&
         word.find_first_not_of("0123456789abcdef-") == std::string::npos;
}

}  // namespace

MachineIdentity MachineToStop(const StopBelief& belief) {
  MachineIdentity here = belief.led.value_or(MachineIdentity{});
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
  const bool by_id = machine.id.empty() && MayBeginId(word) &&
                     std::ranges::none_of(machines, [&word](const MachineHere& one) {
                       return one.identity.name == word;
                     });
  for (const MachineHere& one : machines) {
    const bool same = SameMachine(one.identity, machine);
    const bool may_be = by_id && one.identity.id.empty();
    if (!one.lan || (!may_be && !same)) continue;
    if (!named && !running_here.empty() && !one.HasOneOf(running_here)) continue;
    reach.lan = true;
    if (same && reach.interfaces.empty()) reach.interfaces = one.interfaces;
  }
  return reach;
}

}  // namespace musher::cli
