#pragma once
// What can be told about a process of this host without its help. The real one asks the kernel; the
// simulation has its own.
//
// Threads: loop thread only, callbacks too.

#include <sys/types.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "musher/controller/backtrace.hpp"
#include "musher/lifecycle/health_monitor.hpp"
#include "musher/transport/scheduling.hpp"

namespace musher {

class ProcessWitness {
 public:
  virtual ~ProcessWitness() = default;

  // Remembers how the process stands, so that Examine() can measure from here.
  virtual void Mark(pid_t pid, Time now) = 0;
  // How it stands, and how long it, or this process here, waited for a CPU since the mark.
  virtual Examination Examine(pid_t pid, Time now) = 0;

  // What its threads are doing, for a person to read; `done` runs once, maybe with the reason why
  // that is not to be had.
  virtual void TakeBacktrace(pid_t pid, Duration timeout,
                             std::function<void(Result<std::string>)> done) = 0;
};

class KernelWitness : public ProcessWitness {
 public:
  // Both must outlive the witness.
  KernelWitness(transport::EventLoop& loop, ProcessRunner& processes)
      : backtraces_(loop, processes) {}

  void Mark(pid_t pid, Time now) override;
  Examination Examine(pid_t pid, Time now) override;
  void TakeBacktrace(pid_t pid, Duration timeout,
                     std::function<void(Result<std::string>)> done) override;

 private:
  struct Samples {
    transport::ProcessSample theirs;
    transport::ProcessSample ours;
  };

  std::map<pid_t, Samples> marks_;
  BacktraceTaker backtraces_;
};

}  // namespace musher
