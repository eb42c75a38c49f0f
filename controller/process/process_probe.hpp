#pragma once
// Examines a process of this host without its cooperation. KernelProbe queries the kernel; the
// simulation has its own.
//
// Threads: loop thread only, callbacks too.

#include <sys/types.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/scheduling.hpp"
#include "musher/controller/process/backtrace.hpp"
#include "musher/lifecycle/health/health_monitor.hpp"
#include "musher/lifecycle/machine/start_progress.hpp"

namespace musher {

class ProcessProbe {
 public:
  virtual ~ProcessProbe() = default;

  // Checks that process `pid`, which a status claims, is the actuator's: it is in the session of
  // `child`, the process that we have started for this actuator (0: none), or it holds the
  // actuator's name on this host and belongs to root or our user. The Error gives the reason, with
  // kCodeStateInvalid if there is no such process.
  virtual Result<> Prove(const std::string& actuator, pid_t pid, pid_t child) = 0;

  // Whether process `pid` takes part in the DDS domain of this one, as its sockets show.
  virtual bool SharesDomain(pid_t /*pid*/) { return false; }

  // For each of these actuators: the process that an earlier controller has started for it, or that
  // holds its name and belongs to root or our user; 0: none.
  virtual std::vector<pid_t> Find(const std::vector<std::string>& actuators) = 0;

  // The start time of the process, which distinguishes it from a later one with the same pid; 0: it
  // has exited.
  virtual std::uint64_t StartTimeOf(pid_t pid) = 0;

  // The process that works for `pid`. A process with a single thread and a single child, as a shell
  // or `ros2 run` is, works by its child, and so on; any other by itself.
  virtual pid_t WorkerOf(pid_t pid) { return pid; }

  // How far `pid`, the process that was started for this actuator, has come with its start.
  virtual StartProgress ProgressOf(const std::string& /*actuator*/, pid_t /*pid*/) {
    return StartProgress::kUnknown;
  }

  // Saves the current waiting times for a CPU and the disk, so that Examine() can measure from
  // here. Several actuators may share a process; each has a mark of its own.
  virtual void Mark(ActuatorIndex actuator, pid_t pid, Time now) = 0;
  // The process's run state, and how long it and this process waited for a CPU and the disk since
  // the mark.
  virtual Examination Examine(ActuatorIndex actuator, pid_t pid, Time now) = 0;

  // The backtraces of its threads, as text for people; `done` runs once, with the reason if there
  // are none.
  virtual void TakeBacktrace(pid_t pid, Duration timeout,
                             std::function<void(Result<std::string>)> done) = 0;
};

class KernelProbe : public ProcessProbe {
 public:
  // Loop and processes must outlive the probe. `lock_of` returns the name that the process of an
  // actuator holds (NameLock); it is the mark of the process as well
  // (child_processes.hpp).
  using LockOf = std::function<std::string(const std::string& actuator)>;
  KernelProbe(transport::EventLoop& loop, ProcessRunner& processes, LockOf lock_of)
      : lock_of_(std::move(lock_of)), backtraces_(loop, processes) {}

  Result<> Prove(const std::string& actuator, pid_t pid, pid_t child) override;
  bool SharesDomain(pid_t pid) override;
  std::vector<pid_t> Find(const std::vector<std::string>& actuators) override;
  std::uint64_t StartTimeOf(pid_t pid) override;
  pid_t WorkerOf(pid_t pid) override;
  StartProgress ProgressOf(const std::string& actuator, pid_t pid) override;
  void Mark(ActuatorIndex actuator, pid_t pid, Time now) override;
  Examination Examine(ActuatorIndex actuator, pid_t pid, Time now) override;
  void TakeBacktrace(pid_t pid, Duration timeout,
                     std::function<void(Result<std::string>)> done) override;

 private:
  struct Samples {
    pid_t pid = 0;
    ProcessSample theirs;
    ProcessSample ours;
  };

  const LockOf lock_of_;
  std::map<ActuatorIndex, Samples> marks_;  // by actuator
  BacktraceTaker backtraces_;
};

}  // namespace musher
