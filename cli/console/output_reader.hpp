#pragma once
// The reader of this program's output, as in `musher logs -f | head -1`, as a file descriptor. A
// command that prints for ever ends when its reader has exited, also if it has nothing to print.

#include "musher/base/unique_fd.hpp"

namespace musher::cli {

// A loop finds the descriptor readable once the reader of `output` has exited. Invalid if that is
// no pipe.
UniqueFd TakeReaderOf(int output);

}  // namespace musher::cli
