#include "musher/transport/host.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <system_error>

namespace musher::transport {
namespace {

namespace fs = std::filesystem;

// An abstract address: its path starts with a zero byte and counts to its very last byte.
struct AbstractAddress {
  sockaddr_un address{};
  socklen_t size = 0;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address); }
};

std::optional<AbstractAddress> AddressOf(std::string_view name) {
  const std::string path = std::string(1, '\0') + "musher/" + std::string(name);
  AbstractAddress result;
  if (path.size() > sizeof(result.address.sun_path)) return std::nullopt;
  result.address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), result.address.sun_path);
  result.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  return result;
}

// Datagram: a bound socket can be connected to without anybody listening.
UniqueFd MakeSocket() {
  return UniqueFd(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
}

// The inode of the socket that is bound to an abstract address, by the kernel's table of them:
// "ffff8880: 00000002 00000000 00000000 0002 01 41923 @musher/…", with '@' for the zero byte.
std::string InodeOf(const std::string& address) {
  std::ifstream table("/proc/net/unix");
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    std::string skipped;
    std::string inode;
    std::string path;
    for (int i = 0; i < 6; ++i) words >> skipped;
    if (words >> inode >> path && path == address) return inode;
  }
  return {};
}

bool HasOpen(const fs::path& process, const std::string& target) {
  std::error_code hidden;
  for (const auto& fd : fs::directory_iterator(process / "fd", hidden)) {
    if (fs::read_symlink(fd.path(), hidden) == target) return true;
  }
  return false;
}

}  // namespace

Error SystemError(std::string_view what, int error_number) {
  return {kCodeFailed, std::string(what) + ": " + std::generic_category().message(error_number)};
}

std::string HostId() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string boot;
  struct stat pid_namespace {};
  if (!(file >> boot) || stat("/proc/self/ns/pid", &pid_namespace) != 0) return {};
  return boot + "/" + std::to_string(pid_namespace.st_ino);
}

std::uint64_t NewIncarnation() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U +
         static_cast<std::uint64_t>(now.tv_nsec);
}

Result<UniqueFd> OpenPidfd(pid_t pid) {
  UniqueFd fd(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));  // close-on-exec by itself
  if (!fd.valid()) return SystemError("can't watch process " + std::to_string(pid));
  return fd;
}

std::string NameLock::NameOf(int domain_id, std::string_view name_space,
                             std::string_view actuator) {
  return std::to_string(domain_id) + "/" + std::string(name_space) + "/" + std::string(actuator);
}

Result<NameLock> NameLock::Acquire(std::string_view name) {
  const auto address = AddressOf(name);
  if (!address) return Error{kCodeParametersInvalid, "too long: " + std::string(name)};
  UniqueFd socket = MakeSocket();
  if (!socket.valid()) return SystemError("can't make a socket");
  if (bind(socket.get(), address->get(), address->size) == 0) return NameLock(std::move(socket));
  Error error = SystemError("can't take the name " + std::string(name));
  if (errno == EADDRINUSE) {
    error = {kCodeTargetBusy,
             "a process named " + std::string(name) + " runs on this host already"};
  }
  return error;
}

bool NameLock::IsHeld(std::string_view name) {
  const auto address = AddressOf(name);
  if (!address) return false;
  const UniqueFd socket = MakeSocket();
  return socket.valid() && connect(socket.get(), address->get(), address->size) == 0;
}

pid_t NameLock::HolderOf(std::string_view name) {
  const std::string inode = InodeOf("@musher/" + std::string(name));
  if (inode.empty()) return 0;
  std::error_code ended;
  for (const auto& entry : fs::directory_iterator("/proc", ended)) {
    const pid_t pid = std::atoi(entry.path().filename().c_str());
    if (pid != 0 && HasOpen(entry.path(), "socket:[" + inode + "]")) return pid;
  }
  return 0;
}

}  // namespace musher::transport
