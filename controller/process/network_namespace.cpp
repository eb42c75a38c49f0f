#include "musher/controller/process/network_namespace.hpp"

#include <sys/stat.h>

namespace musher {
namespace {

ino_t NamespaceAt(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 ? info.st_ino : 0;
}

}  // namespace

ino_t NetworkOf(pid_t pid) {
  return pid > 0 ? NamespaceAt("/proc/" + std::to_string(pid) + "/ns/net") : 0;
}

ino_t OwnNetwork() {
  return NamespaceAt("/proc/thread-self/ns/net");
}

bool IsInOtherNetwork(pid_t pid) {
  const ino_t theirs = NetworkOf(pid);
  const ino_t ours = OwnNetwork();
  return theirs != 0 && ours != 0 && theirs != ours;
}

std::string InNetworkOf(pid_t pid, const std::string& command) {
  return "`nsenter --target " + std::to_string(pid) + " --net " + command + "`";
}

}  // namespace musher
