#pragma once
// Faults of a module's process: it ends, or is frozen.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::process {

void Killed(FaultRun& run);
void SeveralKilled(FaultRun& run);
void Terminated(FaultRun& run);
void StoppedForLong(FaultRun& run);
void StoppedShortly(FaultRun& run);
// It exits with this code.
void Exits(FaultRun& run, int code);
void Aborts(FaultRun& run);
void Segfaults(FaultRun& run);
// It exits in each SetUp until it is given up.
void CrashesRepeatedly(FaultRun& run);
// The program inside a musher-exec.
void WrappedProgramKilled(FaultRun& run);

}  // namespace musher::fault_injection::process
