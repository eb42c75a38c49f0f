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

// A name that at most one living process of the host holds, from Acquire() until the lock is
// dropped or the process ends in whatever way. It is an abstract unix socket: no file is left
// behind, nothing has to be cleaned up. Containers share names when they share the network
// namespace.
class NameLock {
 public:
  // The name of an actuator: domains and namespaces keep robots apart that share a host.
  static std::string NameOf(int domain_id, std::string_view name_space, std::string_view actuator);

  // Fails with kCodeTargetBusy when a process holds the name, with kCodeParametersInvalid when the
  // name is longer than the kernel allows (100 bytes).
  static Result<NameLock> Acquire(std::string_view name);

  // Whether a living process holds the name. Never disturbs one that is about to acquire it.
  static bool IsHeld(std::string_view name);

  // The process that holds the name; 0: nobody, or one that we may not look into.
  static pid_t HolderOf(std::string_view name);

 private:
  explicit NameLock(UniqueFd socket) : socket_(std::move(socket)) {}

  UniqueFd socket_;
};

}  // namespace musher::transport
