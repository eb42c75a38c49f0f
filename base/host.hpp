#pragma once
// What processes of one host can find out about each other without messages: whether they share a
// host, whether a process is alive, and whether a name is held. The kernel answers, so the answers
// are correct after kill -9.
//
// Threads: any.

#include <sys/types.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {

// "<what>: No such file or directory", with kCodeFailed.
Error SystemError(std::string_view what, int error_number = errno);

// The scope of a pid: this boot of this machine and the process's pid namespace. Two processes with
// the same HostId may compare pids and watch each other. Empty if /proc is missing: the host is
// then unknown, and two empty ids must not count as equal.
std::string HostId();

// The name that people know the host by; empty: unknown.
std::string HostName();

// The user of this process, for people: "alice@dog1".
std::string UserAtHost();

// Nanoseconds since the host was booted: an id for a process that starts now, higher than that of
// any process that started earlier, independent of the wall clock.
std::uint64_t NewIncarnation();

// How long this computer was suspended since its boot: CLOCK_BOOTTIME counts that, steady time does
// not.
Duration TimeSuspendedHere();

// A descriptor of the process, readable once the process has exited; it never refers to another
// process that reuses the pid. Fails if no such process is alive.
Result<UniqueFd> OpenPidfd(pid_t pid);

// Sends a signal to the process of a pidfd, never to another one that reuses its pid; 0 only checks
// that it exists. False: `errno` has the reason; ESRCH: it has exited and been reaped.
bool SendSignal(int pidfd, int signal);

// Whether process `pid` has the file at `path` open and holds a lock on it. The file's text about
// its owner proves nothing if others may write to its folder. False also if we may not inspect the
// process.
bool HoldsLockOn(pid_t pid, const std::string& path);

// A name that at most one process of the host holds, from Acquire() until the lock is dropped or
// the process exits in any way. It is an abstract unix socket: it leaves no file and needs no
// cleanup. Containers share names if they share the network namespace.
class NameLock {
 public:
  // The name of an actuator: domains and namespaces separate robots that share a host.
  static std::string NameOf(int domain_id, std::string_view name_space, std::string_view actuator);

  // Fails with kCodeTargetBusy if a process holds the name (the error names the process and its
  // user); with kCodeParametersInvalid if the name is longer than the kernel permits (100 bytes).
  static Result<NameLock> Acquire(std::string_view name);

  // Whether a process holds the name. Never disturbs a process that is about to acquire it.
  static bool IsHeld(std::string_view name);

  // The rest after `prefix` of each held name, if it has no further '/': with
  // NameOf(domain, name_space, "") the actuators of a namespace whose processes run on this host.
  static std::vector<std::string> HeldBelow(std::string_view prefix);

  // Whether a process of this host holds a name in a domain, in any namespace, that ends like this.
  static bool IsHeldInDomain(int domain_id, std::string_view end);

  // Any user of the host can take a name. So a holder is trusted only if the process and the lock
  // belong to root or to our own user.
  struct Holder {
    pid_t pid = 0;  // 0: no process holds the name, or the files of its user are not readable
    uid_t uid = 0;  // the user that took the name
    bool trusted = false;  // that user and the process's user are root or our own

    std::string Text() const;  // "process 4711 of user 1000"; "a process of another user"
  };
  // Searches all processes.
  static Holder HolderOf(std::string_view name);
  // The holder of each name of HeldBelow(), in one search.
  static std::map<std::string, Holder> HoldersBelow(std::string_view prefix);

  // Whether process `pid` holds the name and is trusted; the Error gives the reason, with
  // kCodeStateInvalid if there is no such process (any more). Inspects this process only.
  static Result<> CheckHolder(std::string_view name, pid_t pid);

  // Hands a message to the process that holds the name, without any discovery and without waiting.
  // False: no process holds it, or it does not take its messages.
  static bool Send(std::string_view name, std::span<const std::byte> message);
  static constexpr std::size_t kLongestMessage = 4096;

  // Readable while messages wait.
  int fd() const { return socket_.get(); }
  // The next message of a process of root or of our own user, others are dropped; nullopt: none
  // waits. A longer one is cut.
  std::optional<std::vector<std::byte>> Receive();

 private:
  explicit NameLock(UniqueFd socket) : socket_(std::move(socket)) {}

  UniqueFd socket_;
};

// A stream of packets between two processes of this host. ListenAt() takes an abstract address, as
// a NameLock does, and fails as its Acquire(). ConnectTo() does not wait: not valid if no process
// listens, or too many callers wait already.
Result<UniqueFd> ListenAt(std::string_view name, int backlog);
UniqueFd ConnectTo(std::string_view name);

}  // namespace musher
