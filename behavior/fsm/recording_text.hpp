#pragma once
// Words, times and changes in the lines of a recording.

#include <string>
#include <string_view>

#include "musher/behavior/fsm/machine.hpp"

namespace musher::fsm {

inline constexpr std::string_view kRecordingFormat = "musher-fsm-recording 1";
inline constexpr std::string_view kRestored = "restored";

// Puts a space before what it appends, but not at the beginning of a line.
void AppendWord(std::string& line, std::string_view word);
// Seconds, to the nanosecond, without needless zeros.
void AppendTime(std::string& line, Duration time);
void AppendNumber(std::string& line, std::uint64_t number);
// The words after "changed".
void AppendChange(std::string& line, const Machine& machine, const Change& change);

}  // namespace musher::fsm
