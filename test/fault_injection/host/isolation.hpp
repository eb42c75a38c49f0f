#pragma once
// Namespaces of this process, so that its changes to network and mounts affect no other process.
// They end with the last process in them and need no clean-up.

#include <string>

namespace musher::fault_injection {

struct Isolation {
  bool own_network = false;  // its loopback at least
  std::string no_network;    // why two hosts are not possible; "": they are
  std::string no_mounts;     // why mounting is not possible
};

// To be called before there is a second thread. Root makes the namespaces directly, other users in
// a user namespace.
Isolation Isolate();

// In this network namespace.
void BringUp(const std::string& interface);
void TakeDown(const std::string& interface);
void SetAddress(const std::string& interface, const std::string& address);  // of a /24

// Mounts a file system in memory of this size on `folder`. Throws std::system_error, as the above.
void MountMemory(const std::string& folder, int kilobytes);
void MakeReadOnly(const std::string& folder, bool read_only);

}  // namespace musher::fault_injection
