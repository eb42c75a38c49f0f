#include "musher/controller/process_supervisor.hpp"

#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
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

constexpr std::int64_t kMostWords = 2048;   // bytes of a log's end that are looked at
constexpr std::size_t kLongestWords = 200;  // bytes that are told

std::int64_t SizeOf(const std::string& file) {
  std::error_code none;
  const auto size = std::filesystem::file_size(file, none);
  return none ? 0 : static_cast<std::int64_t>(size);
}

// The last line of what stands in `file` from `begin` on that says something.
std::string LastWords(const std::string& file, std::int64_t begin) {
  std::ifstream in(file, std::ios::binary);
  const std::int64_t from = std::max(begin, SizeOf(file) - kMostWords);
  if (!in || !in.seekg(from)) return "";
  std::string line;
  std::string last;
  while (std::getline(in, line)) {
    for (char& c : line) {
      if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';
    }
    const std::size_t first = line.find_first_not_of(' ');
    if (first != std::string::npos)
      last = line.substr(first, line.find_last_not_of(' ') + 1 - first);
  }
  if (last.size() <= kLongestWords) return last;
  std::size_t end = kLongestWords;
  while (end > 0 && (static_cast<unsigned char>(last[end]) & 0xC0U) == 0x80U) --end;  // UTF-8
  return last.substr(0, end) + "…";
}

}  // namespace

std::string ProcessExit::Text() const {
  if (kind == Kind::kUnknown) return "ended (exit code unknown)";
  if (kind == Kind::kExited) {
    return "exit code " + std::to_string(number) + (last_words.empty() ? "" : ": " + last_words);
  }
  const char* name = sigabbrev_np(number);
  return "killed by " + (name ? "SIG" + std::string(name) : "signal " + std::to_string(number));
}

Result<pid_t> ProcessSupervisor::Start(const ProcessSpec& spec, OnExit on_exit) {
  Process process{true, spec.log_file, SizeOf(spec.log_file), {std::move(on_exit)}, {}, nullptr};
  auto pid = Spawn(spec);
  if (!pid) return pid;
  if (auto added = Add(pid.value(), std::move(process)); !added) {
    kill(-pid.value(), SIGKILL);  // a process that can't be watched can't be kept
    Reap(pid.value());
    return added.error();
  }
  return pid;
}

Result<> ProcessSupervisor::Watch(pid_t pid, OnExit on_exit) {
  const auto watched = processes_.find(pid);
  if (watched == processes_.end()) {
    return Add(pid, {false, "", 0, {std::move(on_exit)}, {}, nullptr});
  }
  watched->second.on_exit.push_back(std::move(on_exit));
  return Ok();
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

Result<> ProcessSupervisor::Add(pid_t pid, Process process) {
  auto pidfd = transport::OpenPidfd(pid);
  if (!pidfd) return pidfd.error();
  process.pidfd = std::move(pidfd).value();
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
    const bool discontent = exit.kind == ProcessExit::Kind::kExited && exit.number != 0;
    if (discontent && !process.mapped().log_file.empty()) {
      exit.last_words = LastWords(process.mapped().log_file, process.mapped().log_begin);
    }
  }
  for (const OnExit& on_exit : process.mapped().on_exit) {
    if (on_exit) on_exit(exit);
  }
}

}  // namespace musher
