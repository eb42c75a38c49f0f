#pragma once
// Which states a show has: the five, and those of the extensions that its config asks for.

#include "musher/behavior/fsm/machine.hpp"
#include "musher/modules/wedding/show_config.hpp"
#include "musher/modules/wedding/show_data.hpp"

namespace musher::wedding {

// Registers states, commands and safety checks; `data` outlives the machine.
void AddCast(fsm::Machine& machine, ShowData& data, const ShowConfig& config);

}  // namespace musher::wedding
