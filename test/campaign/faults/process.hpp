#pragma once
// What happens to a process of a module: it dies, or gets no chance to run.

#include "musher/test/campaign/trial.hpp"

namespace musher::campaign::process {

void Killed(Trial& trial);
void SeveralKilled(Trial& trial);
void Terminated(Trial& trial);
void StoppedForLong(Trial& trial);
void StoppedShortly(Trial& trial);
// Ends by itself with this exit code.
void Exits(Trial& trial, int code);
void Aborts(Trial& trial);
void Segfaults(Trial& trial);
// Dies in each SetUp until it is given up.
void CrashesAgainAndAgain(Trial& trial);
// The program inside a musher-exec.
void WrappedProgramKilled(Trial& trial);

}  // namespace musher::campaign::process
