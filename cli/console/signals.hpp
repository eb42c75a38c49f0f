#pragma once
// Signals, such as those that end a program, as a file descriptor.

#include <sys/types.h>

#include <initializer_list>

#include "musher/base/unique_fd.hpp"

namespace musher::cli {

// Blocks the signals for this thread and the threads that it creates from now on; the descriptor
// becomes readable when one arrives. Throws std::system_error if no descriptor is left.
UniqueFd TakeSignals(std::initializer_list<int> signals);

// SIGINT, SIGTERM and SIGHUP.
UniqueFd TakeEndSignals();

// Takes the next signal from the descriptor and the process that sent it; 0 if there is none.
int NextSignal(const UniqueFd& signals, pid_t* sender = nullptr);

}  // namespace musher::cli
