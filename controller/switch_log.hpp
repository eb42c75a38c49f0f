#pragma once
// What became of switches, as journal entries tell it: those of this controller, kept in memory, or
// those of a controller before it, read from the journal.
//
// Threads: none of its own; plain values.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/controller/journal.hpp"
#include "musher/lifecycle/coordinator.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher {

// For JournalEntry::data.
std::string EncodeSwitchNote(const action::SwitchNote& note);

// Of the switch of that epoch and number. `outcome` stays empty when the entries, oldest first,
// tell of its begin alone; `found` is false when not even of that. Number 0 is the last switch of
// the epoch; when there was none, and the entries tell of that epoch, it is found with number 0.
msg::GetSwitch::Response FindSwitch(const std::vector<JournalEntry>& entries, std::uint64_t epoch,
                                    std::uint64_t number);

}  // namespace musher
