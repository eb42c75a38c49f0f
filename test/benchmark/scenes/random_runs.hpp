#pragma once
// Random scenes, one line a run, so that a series can be stopped at any time, split by seeds over
// processes, and added up from the lines of all of them.

#include <cstdint>

namespace musher::benchmark {

struct RandomRunOptions {
  bool flyers = false;      // only scenes of flyers count
  bool looks_down = false;  // they have a sensor that looks down
  bool lands = false;       // LandingScene()
  bool aside = false;       // by 2 m at most, where their place is taken
};

// Runs so many scenes of the seeds from `first` on, with the gate, and prints a line of each to
// stdout. SIGTERM and SIGINT end it after the present run. Returns an exit code: 1 if a robot has
// touched something, has not ended, moves after its end, or says that it has arrived elsewhere.
int RunRandomScenes(std::uint64_t first, int count, const RandomRunOptions& options);

// Reads such lines from stdin and prints the table of all of them. Returns an exit code: 1 as
// above, 2 if there is none.
int AddUpRandomScenes();

}  // namespace musher::benchmark
