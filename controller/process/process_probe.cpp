#include "musher/controller/process/process_probe.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/transport/udp_sockets.hpp"

namespace musher {

// Only descendants of `child` can be in its session.
Result<> KernelProbe::Prove(const std::string& actuator, pid_t pid, pid_t child) {
  if (child != 0 && pid > 0 && getsid(pid) == child) return Ok();
  return NameLock::CheckHolder(lock_of_(actuator), pid);
}

bool KernelProbe::SharesDomain(pid_t pid) {
  return transport::ShareUdpPort(pid, getpid());
}

std::vector<pid_t> KernelProbe::Find(const std::vector<std::string>& actuators) {
  std::vector<MarkedActuator> marked;
  marked.reserve(actuators.size());
  for (const std::string& actuator : actuators) {
    const std::string lock = lock_of_(actuator);
    marked.push_back({actuator, lock, NameLock::IsHeld(lock)});
  }
  std::map<std::string, pid_t> children;
  for (const ChildProcess& child : FindChildren(marked, {})) children[child.actuator] = child.pid;
  std::vector<pid_t> found;
  found.reserve(marked.size());
  for (const MarkedActuator& actuator : marked) {
    const auto child = children.find(actuator.name);
    if (child != children.end()) {
      found.push_back(child->second);
    } else if (actuator.runs) {
      const NameLock::Holder holder = NameLock::HolderOf(actuator.mark);
      found.push_back(holder.trusted ? holder.pid : 0);
    } else {
      found.push_back(0);
    }
  }
  return found;
}

std::uint64_t KernelProbe::StartTimeOf(pid_t pid) {
  return musher::StartTimeOf(pid).value_or(0);
}

pid_t KernelProbe::WorkerOf(pid_t pid) {
  constexpr int kMostWrappers = 8;
  for (int i = 0; i < kMostWrappers; ++i) {
    const std::filesystem::path threads = "/proc/" + std::to_string(pid) + "/task";
    const bool one_thread = EntriesOf(threads).size() == 1;
    std::ifstream file(threads / std::to_string(pid) / "children");
    const std::vector<pid_t> children{std::istream_iterator<pid_t>(file), {}};
    if (!one_thread || children.size() != 1) return pid;
    pid = children.front();
  }
  return pid;
}

// The name may be held by a descendant, as of a shell.
StartProgress KernelProbe::ProgressOf(const std::string& actuator, pid_t pid) {
  const std::string name = lock_of_(actuator);
  const pid_t holder = NameLock::IsHeld(name) ? NameLock::HolderOf(name).pid : 0;
  if (holder > 0 && (holder == pid || getsid(holder) == pid)) return StartProgress::kNamed;
  const auto sample = SampleProcess(WorkerOf(pid), Time());
  if (!sample) return StartProgress::kUnknown;
  const bool busy = std::ranges::any_of(sample->threads, [](const auto& thread) {
    return thread.second.runnable || thread.second.blocked;
  });
  return busy ? StartProgress::kBusy : StartProgress::kIdle;
}

void KernelProbe::Mark(ActuatorIndex actuator, pid_t pid, Time now) {
  const auto theirs = SampleProcess(pid, now);
  const auto ours = SampleProcess(getpid(), now);
  if (theirs && ours) marks_[actuator] = {pid, *theirs, *ours};
}

Examination KernelProbe::Examine(ActuatorIndex actuator, pid_t pid, Time now) {
  Examination found;
  switch (RunStateOf(pid).value_or(ProcessRunState::kRunning)) {
    case ProcessRunState::kRunning:
      break;
    case ProcessRunState::kStopped:
      found.process = Examination::Process::kStopped;
      break;
    case ProcessRunState::kTraced:
      found.process = Examination::Process::kTraced;
      break;
    case ProcessRunState::kExited:
      found.process = Examination::Process::kExited;
      marks_.erase(actuator);
      return found;
  }
  const auto mark = marks_.find(actuator);
  if (mark == marks_.end() || mark->second.pid != pid) return found;
  const auto theirs = SampleProcess(pid, now);
  const auto ours = SampleProcess(getpid(), now);
  if (theirs && ours) {
    const Wait wait = LongestWaitOfBoth({mark->second.theirs, *theirs}, {mark->second.ours, *ours},
                                        gettid(), kLongestDiskWait);
    found.waited = wait.cpu;
    found.on_disk = wait.disk;
  }
  return found;
}

void KernelProbe::TakeBacktrace(pid_t pid, Duration timeout,
                                std::function<void(Result<std::string>)> done) {
  backtraces_.Take(pid, timeout, std::move(done));
}

}  // namespace musher
