#pragma once
// Exhausted resources of a robot's host.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::resource {

// Other processes keep all cores busy.
void CoresAreBusy(FaultRun& run);
// A module allocates more memory than its limit.
void MemoryIsLimited(FaultRun& run);
// The disk of the controller's state folder is full; needs a mount of its own.
void DiskIsFull(FaultRun& run);
// The controller can enlarge no file (RLIMIT_FSIZE).
void FileSizeIsLimited(FaultRun& run);
// The controller gets no more file descriptors for a while.
void FilesAreLimited(FaultRun& run);
// The state folder is removed under the running controller.
void StateFolderVanishes(FaultRun& run);
// A controller starts on a state folder that cannot be written; needs a mount of its own.
void StateFolderIsReadOnly(FaultRun& run);
// The disk of the state folder stalls for a while. Meanwhile an emergency stop is engaged, the
// machine is switched, an actuator is killed, or the machine is torn down; or nothing, for longer
// than the controller may be silent.
void DiskStallsAndStops(FaultRun& run);
void DiskStallsInSwitch(FaultRun& run);
void DiskStallsAndKills(FaultRun& run);
void DiskStallsAndTearsDown(FaultRun& run);
void DiskStallsForLong(FaultRun& run);

}  // namespace musher::fault_injection::resource
