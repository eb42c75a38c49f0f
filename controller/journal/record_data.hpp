#pragma once
// What programs read of a record in the journal: JournalEntry::data.
//
// Threads: none of its own; plain values.

#include <string>

#include "musher/lifecycle/step/action.hpp"

namespace musher {

// A backtrace as it is. Else a JSON object, or empty if it would have no key:
// {"target", "state", "outcome"}, of a switch that begins (no outcome) or has ended;
// {"arguments": {<name>: <number, text, true or false>, …}}, of the sentence.
std::string DataOf(const action::Record& record);

}  // namespace musher
