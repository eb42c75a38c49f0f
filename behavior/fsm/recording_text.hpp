#pragma once
// The lines of a recording that its writer and its readers share.

#include <string>
#include <string_view>

#include "musher/behavior/fsm/machine.hpp"
#include "musher/behavior/recording_line.hpp"

namespace musher::fsm {

// Since 2 the changes of machines inside are recorded.
inline constexpr std::string_view kRecordingFormat = "musher-fsm-recording 2";
inline constexpr std::string_view kRecordingFormat1 = "musher-fsm-recording 1";
inline constexpr std::string_view kRestored = "restored";

// The words after "changed".
void AppendChange(std::string& line, const Machine& machine, const Change& change);
// "inside SHOW photo 3 0.06 CONFIRM TAKE decided": of a machine that a state holds.
void AppendChangeInside(std::string& line, const Machine& inside, const Change& change);

}  // namespace musher::fsm
