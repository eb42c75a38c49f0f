#pragma once
// The command-line tools of musher-wedding, beside the actuator.

namespace musher::wedding::tool {

// Each gets the command line from its own name on, and returns the exit code.

// musher-wedding replay FILE: replays a recording and prints the outcome.
int Replay(int argc, const char* const* argv);
// musher-wedding send gesture heart: publishes an input of the show, in place of a guest, a
// detector or an operator.
int PublishInput(int argc, const char* const* argv);

}  // namespace musher::wedding::tool
