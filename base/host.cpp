#include "musher/base/host.hpp"

#include <pwd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>

#include "musher/base/files.hpp"

namespace musher {
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

// Datagram: connect() to a bound socket needs no listener.
UniqueFd MakeSocket() {
  return UniqueFd(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
}

// The abstract addresses of bound sockets that begin so, without that beginning, and the inodes of
// the sockets, from the kernel's table:
// "ffff8880: 00000002 00000000 00000000 0002 01 41923 @musher/…", with '@' for the zero byte.
std::map<std::string, ino_t> BoundBelow(std::string_view prefix) {
  const std::string begin = "@musher/" + std::string(prefix);
  std::map<std::string, ino_t> bound;
  std::ifstream table("/proc/net/unix");
  for (std::string line; std::getline(table, line);) {
    const std::size_t at = line.find(begin);
    if (at == std::string::npos || at == 0 || line[at - 1] != ' ') continue;
    std::istringstream words(line);
    std::string skipped;
    ino_t inode = 0;
    for (int i = 0; i < 6; ++i) words >> skipped;
    if (words >> inode) bound.emplace(line.substr(at + begin.size()), inode);
  }
  return bound;
}

// The inode of the socket that is bound to a name; 0: none is.
ino_t InodeOf(std::string_view name) {
  const auto bound = BoundBelow(name);
  const auto found = bound.find("");
  return found == bound.end() ? 0 : found->second;
}

// A descriptor of a process.
struct OpenFile {
  fs::path descriptor;  // "/proc/4711/fd/5"
  struct stat status {};
};

// The first descriptor of a process that `wanted` accepts; nullopt: none, or they are not visible.
template <typename Wanted>
std::optional<OpenFile> FindOpen(pid_t pid, const Wanted& wanted) {
  const fs::path folder = fs::path("/proc") / std::to_string(pid) / "fd";
  for (const fs::path& descriptor : EntriesOf(folder)) {
    OpenFile file{descriptor, {}};
    if (stat(file.descriptor.c_str(), &file.status) == 0 && wanted(file)) return file;
  }
  return std::nullopt;
}

bool IsTrusted(uid_t uid) {
  return uid == 0 || uid == geteuid();
}

using Holders = std::map<ino_t, NameLock::Holder>;  // by the inodes of sockets

// Notes the process as the holder of those sockets without one that it has. Returns whether each
// has one then.
bool NoteHolder(pid_t pid, Holders& holders) {
  struct stat process {};
  if (stat(("/proc/" + std::to_string(pid)).c_str(), &process) != 0) return false;
  const auto all = [&] {
    return std::ranges::none_of(holders, [](const auto& one) { return one.second.pid == 0; });
  };
  return FindOpen(pid,
                  [&](const OpenFile& file) {
                    if (!S_ISSOCK(file.status.st_mode)) return false;
                    const auto held = holders.find(file.status.st_ino);
                    if (held == holders.end() || held->second.pid != 0) return false;
                    const uid_t user = file.status.st_uid;
                    held->second = {pid, user, IsTrusted(user) && IsTrusted(process.st_uid)};
                    return all();
                  })
      .has_value();
}

// Searches all processes, once.
void FindHolders(Holders& holders) {
  if (holders.empty()) return;
  for (const fs::path& process : EntriesOf("/proc")) {
    const pid_t pid = std::atoi(process.filename().c_str());
    if (pid != 0 && NoteHolder(pid, holders)) return;
  }
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

std::string HostName() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::string UserAtHost() {
  std::array<char, 4096> text{};
  passwd entry{};
  passwd* user = nullptr;
  getpwuid_r(getuid(), &entry, text.data(), text.size(), &user);
  return (user != nullptr ? std::string(user->pw_name) : std::to_string(getuid())) + "@" +
         HostName();
}

std::uint64_t NewIncarnation() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U +
         static_cast<std::uint64_t>(now.tv_nsec);
}

Duration TimeSuspendedHere() {
  const auto now = [](clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  };
  const auto monotonic = now(CLOCK_MONOTONIC);  // first, so that the result is never below 0
  return now(CLOCK_BOOTTIME) - monotonic;
}

Result<UniqueFd> OpenPidfd(pid_t pid) {
  UniqueFd fd(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));  // close-on-exec by itself
  if (!fd.valid()) return SystemError("can't watch process " + std::to_string(pid));
  return fd;
}

bool SendSignal(int pidfd, int signal) {
  return syscall(SYS_pidfd_send_signal, pidfd, signal, nullptr, 0) == 0;
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
  const int with_sender = 1;
  setsockopt(socket.get(), SOL_SOCKET, SO_PASSCRED, &with_sender, sizeof(with_sender));
  if (bind(socket.get(), address->get(), address->size) == 0) return NameLock(std::move(socket));
  Error error = SystemError("can't take the name " + std::string(name));
  if (errno == EADDRINUSE) {
    error = {kCodeTargetBusy, "a process named " + std::string(name) +
                                  " already runs on this host: " + HolderOf(name).Text()};
  }
  return error;
}

bool NameLock::IsHeld(std::string_view name) {
  const auto address = AddressOf(name);
  if (!address) return false;
  const UniqueFd socket = MakeSocket();
  return socket.valid() && connect(socket.get(), address->get(), address->size) == 0;
}

std::string NameLock::Holder::Text() const {
  if (pid == 0) return "a process of another user";
  return "process " + std::to_string(pid) + " of user " + std::to_string(uid);
}

std::vector<std::string> NameLock::HeldBelow(std::string_view prefix) {
  std::vector<std::string> names;
  for (const auto& [name, inode] : BoundBelow(prefix)) {
    if (!name.empty() && name.find('/') == std::string::npos) names.push_back(name);
  }
  return names;
}

std::map<std::string, NameLock::Holder> NameLock::HoldersBelow(std::string_view prefix) {
  const auto bound = BoundBelow(prefix);
  Holders holders;
  for (const auto& [name, inode] : bound) {
    if (!name.empty() && name.find('/') == std::string::npos) holders[inode];
  }
  FindHolders(holders);
  std::map<std::string, Holder> named;
  for (const auto& [name, inode] : bound) {
    if (holders.contains(inode)) named[name] = holders[inode];
  }
  return named;
}

bool NameLock::IsHeldInDomain(int domain_id, std::string_view end) {
  const std::string begin = " @musher/" + std::to_string(domain_id) + "/";
  std::ifstream table("/proc/net/unix");
  for (std::string line; std::getline(table, line);) {
    if (line.find(begin) != std::string::npos && line.ends_with(end)) return true;
  }
  return false;
}

bool NameLock::Send(std::string_view name, std::span<const std::byte> message) {
  const auto address = AddressOf(name);
  const UniqueFd socket = MakeSocket();
  if (!address || !socket.valid()) return false;
  const ssize_t sent = sendto(socket.get(), message.data(), message.size(),
                              MSG_DONTWAIT | MSG_NOSIGNAL, address->get(), address->size);
  return sent == static_cast<ssize_t>(message.size());
}

std::optional<std::vector<std::byte>> NameLock::Receive() {
  std::vector<std::byte> message(kLongestMessage);
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ucred))> control{};
  for (;;) {
    iovec part{message.data(), message.size()};
    msghdr header{};
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    header.msg_control = control.data();
    header.msg_controllen = control.size();
    const ssize_t size = recvmsg(socket_.get(), &header, MSG_DONTWAIT);
    if (size < 0) return std::nullopt;
    const cmsghdr* sender = CMSG_FIRSTHDR(&header);
    if (sender == nullptr || sender->cmsg_type != SCM_CREDENTIALS) continue;
    ucred credentials{};
    std::memcpy(&credentials, CMSG_DATA(sender), sizeof(credentials));
    if (!IsTrusted(credentials.uid)) continue;
    message.resize(static_cast<std::size_t>(size));
    return message;
  }
}

NameLock::Holder NameLock::HolderOf(std::string_view name) {
  const ino_t inode = InodeOf(name);
  if (inode == 0) return {};
  Holders holders{{inode, {}}};
  FindHolders(holders);
  return holders[inode];
}

Result<> NameLock::CheckHolder(std::string_view name, pid_t pid) {
  const std::string process = "process " + std::to_string(pid);
  std::error_code error;
  if (pid <= 0 || !fs::exists("/proc/" + std::to_string(pid), error)) {
    return Error{kCodeStateInvalid, "there is no " + process};
  }
  const ino_t inode = InodeOf(name);
  if (inode == 0) {
    return Error{kCodePermissionDenied, "no process of this host holds its name"};
  }
  Holders holders{{inode, {}}};
  NoteHolder(pid, holders);
  const Holder holder = holders[inode];
  if (holder.pid == 0) {
    return Error{kCodePermissionDenied,
                 process + " does not hold its name, or is of a user whose files cannot be read"};
  }
  if (holder.trusted) return Ok();
  return Error{kCodePermissionDenied, "its name is held by " + holder.Text() +
                                          ", which is neither root nor user " +
                                          std::to_string(geteuid()) + ", as this one is"};
}

// "lock:\t1: FLOCK  ADVISORY  WRITE 4711 fe:00:123 0 EOF"
bool HoldsLockOn(pid_t pid, const std::string& path) {
  struct stat locked {};
  if (pid <= 0 || stat(path.c_str(), &locked) != 0) return false;
  return FindOpen(
             pid,
             [&](const OpenFile& file) {
               if (file.status.st_dev != locked.st_dev || file.status.st_ino != locked.st_ino) {
                 return false;
               }
               std::ifstream info(file.descriptor.parent_path().parent_path() / "fdinfo" /
                                  file.descriptor.filename());
               for (std::string line; std::getline(info, line);) {
                 if (line.starts_with("lock:") && line.find("WRITE") != std::string::npos)
                   return true;
               }
               return false;
             })
      .has_value();
}

Result<UniqueFd> ListenAt(std::string_view name, int backlog) {
  const auto address = AddressOf(name);
  if (!address) return Error{kCodeParametersInvalid, "too long: " + std::string(name)};
  UniqueFd listening(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!listening.valid() || bind(listening.get(), address->get(), address->size) != 0 ||
      listen(listening.get(), backlog) != 0) {
    return SystemError("can't listen at " + std::string(name));
  }
  return listening;
}

UniqueFd ConnectTo(std::string_view name) {
  const auto address = AddressOf(name);
  UniqueFd connection(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!address || !connection.valid() ||
      connect(connection.get(), address->get(), address->size) != 0) {
    return {};
  }
  return connection;
}

}  // namespace musher
