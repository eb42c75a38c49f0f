#pragma once
// The program without main().

#include <ostream>

namespace musher::cli {

// Runs one command line and returns the process's exit code. `terminal`: whether `out` is one.
int Run(int argc, const char* const* argv, std::ostream& out, std::ostream& err, bool terminal);

}  // namespace musher::cli
