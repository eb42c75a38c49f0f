#pragma once
// The network namespaces of the processes of this computer. DDS and the names of processes
// (NameLock) reach the processes of one namespace only. A state folder, locks of its files and pids
// may be common to several.
//
// Threads: any; reads /proc, never waits.

#include <sys/types.h>

#include <string>

namespace musher {

// The kernel's number of the namespace; 0: the process has exited, or this user may not inspect it.
ino_t NetworkOf(pid_t pid);
// The number of the calling thread's namespace.
ino_t OwnNetwork();

// Whether the process is known to be in another one than the calling thread.
bool IsInOtherNetwork(pid_t pid);

// "`nsenter --target 4711 --net musher status`": how root runs a command in the network of a
// process.
std::string InNetworkOf(pid_t pid, const std::string& command);

}  // namespace musher
