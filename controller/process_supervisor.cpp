#include "musher/controller/process_supervisor.hpp"

#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "musher/controller/spawn.hpp"
#include "musher/transport/host.hpp"

namespace musher {
namespace {

// Takes a child that has ended off the kernel's books. Until then its pid can't be reused, so the
// pid is as good a handle as the pidfd.
ProcessExit Reap(pid_t pid) {
  siginfo_t info{};
  int result = 0;
  do {
    result = waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED);
  } while (result != 0 && errno == EINTR);
  if (result != 0) return {};
  const bool exited = info.si_code == CLD_EXITED;
  return {exited ? ProcessExit::Kind::kExited : ProcessExit::Kind::kKilled, info.si_status};
}

}  // namespace

std::string ProcessExit::Text() const {
  if (kind == Kind::kUnknown) return "ended (exit code unknown)";
  if (kind == Kind::kExited) return "exit code " + std::to_string(number);
  const char* name = sigabbrev_np(number);
  return "killed by " + (name ? "SIG" + std::string(name) : "signal " + std::to_string(number));
}

Result<pid_t> ProcessSupervisor::Start(const ProcessSpec& spec, OnExit on_exit) {
  auto pid = Spawn(spec);
  if (!pid) return pid;
  if (auto added = Add(pid.value(), /*is_child=*/true, std::move(on_exit)); !added) {
    kill(-pid.value(), SIGKILL);  // a process that can't be watched can't be kept
    Reap(pid.value());
    return added.error();
  }
  return pid;
}

Result<> ProcessSupervisor::Watch(pid_t pid, OnExit on_exit) {
  if (processes_.contains(pid)) {
    return Error{kCodeTargetBusy, "process " + std::to_string(pid) + " is watched already"};
  }
  return Add(pid, /*is_child=*/false, std::move(on_exit));
}

Result<> ProcessSupervisor::Signal(pid_t pid, int signal) {
  const auto found = processes_.find(pid);
  if (found == processes_.end()) {
    return Error{kCodeFailed, "process " + std::to_string(pid) + " is not ours or has ended"};
  }
  // The pidfd names the right process even when the pid has been reused; a group has only its
  // number.
  const auto send = [&](int which) {
    return syscall(SYS_pidfd_send_signal, found->second.pidfd.get(), which, nullptr, 0) == 0;
  };
  const bool leads_group = send(0) && getpgid(pid) == pid && pid != getpgrp();
  if (leads_group ? kill(-pid, signal) == 0 : send(signal)) return Ok();
  return transport::SystemError("can't send signal " + std::to_string(signal) + " to process " +
                                std::to_string(pid));
}

Result<> ProcessSupervisor::Add(pid_t pid, bool is_child, OnExit on_exit) {
  auto pidfd = transport::OpenPidfd(pid);
  if (!pidfd) return pidfd.error();
  Process process{is_child, std::move(on_exit), std::move(pidfd).value(), nullptr};
  process.watch = loop_.WhenReadable(process.pidfd.get(), [this, pid] { Ended(pid); });
  processes_.emplace(pid, std::move(process));
  return Ok();
}

void ProcessSupervisor::Ended(pid_t pid) {
  const auto process = processes_.extract(pid);  // `on_exit` may start the next one
  ProcessExit exit;
  if (process.mapped().is_child) {
    kill(-pid, SIGKILL);  // before the leader is reaped, while the group's number is surely its own
    exit = Reap(pid);
  }
  if (process.mapped().on_exit) process.mapped().on_exit(exit);
}

}  // namespace musher
