#pragma once
// Namespaces of this process, so that nothing it does to network and mounts reaches anybody else.
// They end with the last process in them; nothing has to be cleaned up.

#include <string>

namespace musher::fault_injection {

struct Isolation {
  bool own_network = false;  // its loopback at least
  std::string no_network;    // why there cannot be two hosts; "": there can
  std::string no_mounts;     // why nothing can be mounted
};

// To be called before there is a second thread. Root makes them; others try a user namespace, in
// which they may.
Isolation Isolate();

// In this network namespace.
void BringUp(const std::string& interface);
void TakeDown(const std::string& interface);
void SetAddress(const std::string& interface, const std::string& address);  // of a /24

// A file system in memory of this size on `folder`. Throws std::system_error, as those above.
void MountMemory(const std::string& folder, int kilobytes);
void MakeReadOnly(const std::string& folder, bool read_only);

}  // namespace musher::fault_injection
