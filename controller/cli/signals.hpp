#pragma once
// Signals, such as those that ask a program to end, as a file descriptor.

#include <sys/types.h>

#include <initializer_list>

#include "musher/transport/unique_fd.hpp"

namespace musher::cli {

// Blocks the signals for this thread and those it makes from now on; the descriptor becomes
// readable when one has come. Throws std::system_error when there are no descriptors left.
transport::UniqueFd TakeSignals(std::initializer_list<int> signals);

// SIGINT, SIGTERM and SIGHUP.
transport::UniqueFd TakeEndSignals();

// The signal that made the descriptor readable, taken, and which process sent it; 0 when there is
// none.
int NextSignal(const transport::UniqueFd& signals, pid_t* sender = nullptr);

}  // namespace musher::cli
