#pragma once
// Which states a show has: the five, and those of the extensions that its config asks for.

#include "musher/behavior/fsm/machine.hpp"
#include "musher/modules/wedding/extension/actions.hpp"
#include "musher/modules/wedding/show_config.hpp"
#include "musher/modules/wedding/show_data.hpp"

namespace musher::wedding {

// Registers states, commands and safety checks. `data` and `actions` outlive the machine; `actions`
// is null for a show without action packs.
void AddCast(fsm::Machine& machine, ShowData& data, const ShowConfig& config,
             ActionPlayer* actions = nullptr);

}  // namespace musher::wedding
