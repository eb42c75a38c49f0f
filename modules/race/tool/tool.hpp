#pragma once
// The command-line tools of musher-race, beside the actuator.

namespace musher::race::tool {

// Each gets the command line from its own name on, and returns the exit code.

// musher-race check COURSE: reports every error of a course, or what it has.
int Check(int argc, const char* const* argv);
// musher-race course HALL COURSE: prints a course for the measures of another hall.
int WriteCourse(int argc, const char* const* argv);
// musher-race replay FILE COURSE: replays a recording and prints the outcome.
int Replay(int argc, const char* const* argv);
// musher-race send START: publishes a command of a running race.
int PublishCommand(int argc, const char* const* argv);

}  // namespace musher::race::tool
