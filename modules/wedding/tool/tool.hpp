#pragma once
// What musher-wedding does for people, beside being an actuator.

namespace musher::wedding::tool {

// Each is given the command line from its own name on, and gives the exit code.

// musher-wedding replay FILE: plays a recording, prints what came of it.
int Replay(int argc, const char* const* argv);
// musher-wedding tell gesture heart: publishes what a guest, a detector or a person would.
int Tell(int argc, const char* const* argv);

}  // namespace musher::wedding::tool
