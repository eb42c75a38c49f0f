#pragma once
// The outcomes of switches from journal entries: of this controller from its memory, of an earlier
// controller from the journal.
//
// Threads: none of its own; plain values.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/controller/journal/journal.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher {

// The outcome of the switch with that epoch and number. `outcome` is empty if the entries, oldest
// first, contain only its begin; `found` is false if they do not contain even that. Number 0 is the
// last switch of the epoch; if there was none and the entries cover that epoch, `found` is true
// with number 0.
msg::GetSwitch::Response FindSwitch(const std::vector<JournalEntry>& entries, Epoch epoch,
                                    CommandNumber number);

}  // namespace musher
