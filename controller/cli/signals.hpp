#pragma once
// The signals that ask a program to end, as a file descriptor.

#include "musher/transport/unique_fd.hpp"

namespace musher::cli {

// Blocks SIGINT, SIGTERM and SIGHUP for this thread and those it makes from now on; the descriptor
// becomes readable when one has come. Throws std::system_error when there are no descriptors left.
transport::UniqueFd TakeEndSignals();

// The signal that made the descriptor readable, taken; 0 when there is none.
int NextSignal(const transport::UniqueFd& signals);

}  // namespace musher::cli
