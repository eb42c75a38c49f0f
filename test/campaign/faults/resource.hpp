#pragma once
// What a robot's host runs out of.

#include "musher/test/campaign/trial.hpp"

namespace musher::campaign::resource {

// Others keep all cores busy.
void CoresAreBusy(Trial& trial);
// A module may not have more memory, and asks for more.
void MemoryIsLimited(Trial& trial);
// The disk of the controller's state folder is full; needs a mount of its own.
void DiskIsFull(Trial& trial);
// The controller may write no file beyond its present size (RLIMIT_FSIZE).
void FileSizeIsLimited(Trial& trial);
// The controller gets no more file descriptors for a while.
void FilesAreLimited(Trial& trial);
// The state folder is removed under the running controller.
void StateFolderVanishes(Trial& trial);
// A controller starts on a state folder that cannot be written; needs a mount of its own.
void StateFolderIsReadOnly(Trial& trial);
// The disk of the state folder does not answer for a while: an emergency stop is engaged meanwhile,
// the machine is switched, an actuator is killed, the machine is torn down; or nothing, for longer
// than the controller may be silent.
void DiskStallsAndStops(Trial& trial);
void DiskStallsInSwitch(Trial& trial);
void DiskStallsAndKills(Trial& trial);
void DiskStallsAndTearsDown(Trial& trial);
void DiskStallsForLong(Trial& trial);

}  // namespace musher::campaign::resource
