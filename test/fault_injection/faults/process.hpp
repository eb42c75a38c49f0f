#pragma once
// What happens to a process of a module: it dies, or gets no chance to run.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::process {

void Killed(FaultRun& run);
void SeveralKilled(FaultRun& run);
void Terminated(FaultRun& run);
void StoppedForLong(FaultRun& run);
void StoppedShortly(FaultRun& run);
// Ends by itself with this exit code.
void Exits(FaultRun& run, int code);
void Aborts(FaultRun& run);
void Segfaults(FaultRun& run);
// Dies in each SetUp until it is given up.
void CrashesAgainAndAgain(FaultRun& run);
// The program inside a musher-exec.
void WrappedProgramKilled(FaultRun& run);

}  // namespace musher::fault_injection::process
