#include "musher/test/fault_injection/host/isolation.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <system_error>

#include "musher/base/unique_fd.hpp"

namespace musher::fault_injection {
namespace {

[[noreturn]] void FailToIsolate(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

// Becomes root of a new user namespace; outside it is still this user.
bool BecomeRootOfUserNamespace() {
  const uid_t user = getuid();
  const gid_t group = getgid();
  if (unshare(CLONE_NEWUSER) != 0) return false;
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream users("/proc/self/uid_map");
  users << "0 " << user << " 1" << std::flush;
  std::ofstream groups("/proc/self/gid_map");
  groups << "0 " << group << " 1" << std::flush;
  return users.good() && groups.good();
}

ifreq Request(const std::string& interface) {
  ifreq request{};
  std::snprintf(request.ifr_name, sizeof(request.ifr_name), "%s", interface.c_str());
  return request;
}

void Control(unsigned long what, ifreq request) {
  const UniqueFd any(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (ioctl(any.get(), what, &request) != 0) FailToIsolate(request.ifr_name);
}

void SetFlags(const std::string& interface, bool up) {
  ifreq request = Request(interface);
  request.ifr_flags = static_cast<short>(IFF_MULTICAST | IFF_BROADCAST | (up ? IFF_UP : 0));
  Control(SIOCSIFFLAGS, request);
}

void SetAddressAs(const std::string& interface, const std::string& address, unsigned long what) {
  ifreq request = Request(interface);
  auto& in = reinterpret_cast<sockaddr_in&>(request.ifr_addr);
  in.sin_family = AF_INET;
  inet_pton(AF_INET, address.c_str(), &in.sin_addr);
  Control(what, request);
}

}  // namespace

Isolation Isolate() {
  Isolation isolation;
  if (geteuid() != 0 && !BecomeRootOfUserNamespace()) {
    isolation.no_network = "not root, and this user may not make a user namespace";
    isolation.no_mounts = isolation.no_network;
    return isolation;
  }
  if (unshare(CLONE_NEWNS) != 0 ||
      mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) {
    isolation.no_mounts = std::string("no mount namespace: ") + std::strerror(errno);
  }
  if (unshare(CLONE_NEWNET) != 0) {
    isolation.no_network = std::string("no network namespace: ") + std::strerror(errno);
    return isolation;
  }
  isolation.own_network = true;
  BringUp("lo");
  if (access("/dev/net/tun", R_OK | W_OK) != 0) {
    isolation.no_network = std::string("no link, /dev/net/tun: ") + std::strerror(errno);
  } else if (!isolation.no_mounts.empty()) {
    isolation.no_network = "a second host needs mounts: " + isolation.no_mounts;
  }
  return isolation;
}

void BringUp(const std::string& interface) {
  SetFlags(interface, true);
}

void TakeDown(const std::string& interface) {
  SetFlags(interface, false);
}

void SetAddress(const std::string& interface, const std::string& address) {
  SetAddressAs(interface, address, SIOCSIFADDR);
  SetAddressAs(interface, "255.255.255.0", SIOCSIFNETMASK);
}

void MountMemory(const std::string& folder, int kilobytes) {
  const std::string size = "size=" + std::to_string(kilobytes) + "k";
  if (mount("tmpfs", folder.c_str(), "tmpfs", 0, size.c_str()) != 0) FailToIsolate(folder);
}

void MakeReadOnly(const std::string& folder, bool read_only) {
  const unsigned long flags = MS_REMOUNT | MS_BIND | (read_only ? MS_RDONLY : 0);
  if (mount(nullptr, folder.c_str(), nullptr, flags, nullptr) != 0) FailToIsolate(folder);
}

}  // namespace musher::fault_injection
