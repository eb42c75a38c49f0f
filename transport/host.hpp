#pragma once
// What the processes of one host can know of each other without a message: whether they share a
// host, whether a process still lives, and whether a name is taken. The kernel answers, so the
// answers stay right after kill -9.
//
// Threads: any.

#include <sys/types.h>

#include <cerrno>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher::transport {

// "<what>: No such file or directory", with kCodeFailed.
Error SystemError(std::string_view what, int error_number = errno);

// Where a pid means something: this boot of this machine and the process's pid namespace. Two
// processes with the same HostId may compare pids and watch each other. Empty when /proc is
// missing: then nothing is known, and it must not be taken for equal.
std::string HostId();

// Nanoseconds since the host was booted: a number for a process that starts now, higher than that
// of any that started before, whatever becomes of the wall clock.
std::uint64_t NewIncarnation();

// A descriptor of the process, readable as soon as the process has ended, and never of another one
// that gets its pid later. Fails when no such process lives.
Result<UniqueFd> OpenPidfd(pid_t pid);

// Whether process `pid` has the file at `path` open and holds a lock on it by that: what a file
// says about its owner is anybody's word where others may write to its folder. False as well where
// we may not look into the process.
bool HoldsLockOn(pid_t pid, const std::string& path);

// A name that at most one living process of the host holds, from Acquire() until the lock is
// dropped or the process ends in whatever way. It is an abstract unix socket: no file is left
// behind, nothing has to be cleaned up. Containers share names when they share the network
// namespace.
class NameLock {
 public:
  // The name of an actuator: domains and namespaces keep robots apart that share a host.
  static std::string NameOf(int domain_id, std::string_view name_space, std::string_view actuator);

  // Fails with kCodeTargetBusy when a process holds the name, and says which one and whose it is;
  // with kCodeParametersInvalid when the name is longer than the kernel allows (100 bytes).
  static Result<NameLock> Acquire(std::string_view name);

  // Whether a living process holds the name. Never disturbs one that is about to acquire it.
  static bool IsHeld(std::string_view name);

  // What follows `prefix` in the names that are held, where that has no further '/': with
  // NameOf(domain, name_space, "") the actuators of a namespace whose processes run on this host.
  static std::vector<std::string> HeldBelow(std::string_view prefix);

  // Names are free to any user of the host. So the process that holds one counts only if it is
  // root's or of our own user, and so is the lock.
  struct Holder {
    pid_t pid = 0;         // 0: no process holds the name, or it is of a user whose files are not
                           // ours to read
    uid_t uid = 0;         // the user that took the name
    bool trusted = false;  // it is root or us, and so is the user of the process

    std::string Text() const;  // "process 4711 of user 1000"; "a process of another user"
  };
  // Looks through all processes.
  static Holder HolderOf(std::string_view name);

  // Whether process `pid` holds the name and is to be trusted; the Error says why not, with
  // kCodeStateInvalid when there is no such process (any more). Looks at this process alone.
  static Result<> CheckHolder(std::string_view name, pid_t pid);

 private:
  explicit NameLock(UniqueFd socket) : socket_(std::move(socket)) {}

  UniqueFd socket_;
};

}  // namespace musher::transport
