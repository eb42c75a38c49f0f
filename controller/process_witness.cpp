#include "musher/controller/process_witness.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

namespace musher {

void KernelWitness::Mark(pid_t pid, Time now) {
  const auto theirs = transport::SampleProcess(pid, now);
  const auto ours = transport::SampleProcess(getpid(), now);
  if (theirs && ours) marks_[pid] = {*theirs, *ours};
}

Examination KernelWitness::Examine(pid_t pid, Time now) {
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
      marks_.erase(pid);
      return found;
  }
  const auto mark = marks_.find(pid);
  if (mark == marks_.end()) return found;
  // What we were kept from hearing is not their silence either.
  const auto theirs = transport::SampleProcess(pid, now);
  const auto ours = transport::SampleProcess(getpid(), now);
  if (theirs) found.waited = transport::LongestWait(mark->second.theirs, *theirs);
  if (ours) {
    found.waited = std::max(found.waited, transport::LongestWait(mark->second.ours, *ours));
  }
  return found;
}

void KernelWitness::TakeBacktrace(pid_t pid, Duration timeout,
                                  std::function<void(Result<std::string>)> done) {
  backtraces_.Take(pid, timeout, std::move(done));
}

}  // namespace musher
