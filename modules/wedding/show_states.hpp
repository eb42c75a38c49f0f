#pragma once
// The states of a show: the five of the module, and those of the extensions that its config
// enables.

#include "musher/behavior/fsm/machine.hpp"
#include "musher/modules/wedding/data/show_data.hpp"
#include "musher/modules/wedding/extension/actions.hpp"
#include "musher/modules/wedding/show_config.hpp"

namespace musher::wedding {

// Registers states, commands and safety checks. `data` and `actions` outlive the machine; `actions`
// is null for a show without action packs.
void AddStates(fsm::Machine& machine, ShowData& data, const ShowConfig& config,
               ActionPlayer* actions = nullptr);

}  // namespace musher::wedding
