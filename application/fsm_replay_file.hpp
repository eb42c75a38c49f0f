#pragma once
// Replays the file of an FsmRecording, without a robot and as fast as possible: prints each change
// of the state, and the first difference.
//
// Threads: one.

#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/behavior/fsm/machine.hpp"

namespace musher {

// Applies an input that the application's recorder has written.
using ReplayedInput = std::function<Result<>(std::string_view input, std::string_view text)>;

// Makes the application that is replayed: registers its states, builds the machine, and takes it
// out of the pause in which it begins. The function that is returned owns the application, which
// thus ends before the machine. Its outputs are its own matter, usually ignored.
using ReplayedApplication = std::function<Result<ReplayedInput>(fsm::Machine& machine)>;

// Exit codes of a program that replays.
enum class ReplayExit : int { kIdentical = 0, kDifferent = 1, kNoRecording = 2 };

// Prints to `out`, and to `err` why a file is no recording of this application: with its line.
ReplayExit ReplayFile(const std::string& file, const ReplayedApplication& application,
                      std::ostream& out, std::ostream& err);

}  // namespace musher
