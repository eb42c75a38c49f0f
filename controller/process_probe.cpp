#include "musher/controller/process_probe.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "musher/transport/host.hpp"

namespace musher {

// Only descendants of `child` can be in its session.
Result<> KernelProbe::Prove(const std::string& actuator, pid_t pid, pid_t child) {
  if (child != 0 && pid > 0 && getsid(pid) == child) return Ok();
  return transport::NameLock::CheckHolder(lock_of_(actuator), pid);
}

pid_t KernelProbe::Find(const std::string& actuator) {
  const std::string lock = lock_of_(actuator);
  if (!transport::NameLock::IsHeld(lock)) return 0;  // avoids a search through all processes
  const transport::NameLock::Holder holder = transport::NameLock::HolderOf(lock);
  return holder.trusted ? holder.pid : 0;
}

void KernelProbe::Mark(std::size_t actuator, pid_t pid, Time now) {
  const auto theirs = transport::SampleProcess(pid, now);
  const auto ours = transport::SampleProcess(getpid(), now);
  if (theirs && ours) marks_[actuator] = {pid, *theirs, *ours};
}

Examination KernelProbe::Examine(std::size_t actuator, pid_t pid, Time now) {
  using transport::ProcessRunState;
  Examination found;
  switch (transport::RunStateOf(pid).value_or(ProcessRunState::kRunning)) {
    case ProcessRunState::kRunning:
      break;
    case ProcessRunState::kStopped:
      found.process = Examination::Process::kStopped;
      break;
    case ProcessRunState::kTraced:
      found.process = Examination::Process::kTraced;
      break;
    case ProcessRunState::kGone:
      found.process = Examination::Process::kGone;
      marks_.erase(actuator);
      return found;
  }
  const auto mark = marks_.find(actuator);
  if (mark == marks_.end() || mark->second.pid != pid) return found;
  // Time in which this process waited for a CPU does not count as their silence either.
  const auto theirs = transport::SampleProcess(pid, now);
  const auto ours = transport::SampleProcess(getpid(), now);
  if (theirs) found.waited = transport::LongestWait(mark->second.theirs, *theirs);
  if (ours) {
    found.waited = std::max(found.waited, transport::LongestWait(mark->second.ours, *ours));
  }
  return found;
}

void KernelProbe::TakeBacktrace(pid_t pid, Duration timeout,
                                std::function<void(Result<std::string>)> done) {
  backtraces_.Take(pid, timeout, std::move(done));
}

}  // namespace musher
