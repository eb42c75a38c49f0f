#pragma once
// What the kernel says of the threads of a process of this host, without asking the process:
// whether they are stopped, and how long they ran and waited for a CPU. It tells a silent process
// that was kept from running by others from one that had its chances and hangs.
//
// Nothing is kept and nothing is waited for; a look costs two small files of /proc a thread.
//
// Threads: any. Nothing throws; what can't be read is nullopt.

#include <sys/types.h>

#include <map>
#include <optional>

#include "musher/lifecycle/time.hpp"

namespace musher::transport {

// Since the thread began. Both zero on a kernel built without schedstats.
struct CpuTime {
  Duration ran{};
  Duration waited{};  // ready to run, but another one had the CPU; counted once the wait has ended

  friend bool operator==(const CpuTime&, const CpuTime&) = default;
};

std::optional<CpuTime> ThreadCpuTime(pid_t pid, pid_t tid);

struct ThreadSample {
  CpuTime cpu;
  bool runnable = false;  // runs, or waits for a CPU

  friend bool operator==(const ThreadSample&, const ThreadSample&) = default;
};

// One look at a process.
struct ProcessSample {
  Time at{};
  std::map<pid_t, ThreadSample> threads;  // by tid
  Duration throttled{};  // that the CPU quota of its cgroup has taken from those in it, so far
};

// What a cgroup's CPU quota has taken from those in it, over all CPUs; zero where there is no
// quota, or it is not shown to us.
Duration ThrottledTime(pid_t pid);

// nullopt when there is no such process, or it has only threads that ended.
std::optional<ProcessSample> SampleProcess(pid_t pid, Time now);

// How long a thread waited for a CPU between two looks, or was kept from one by a quota; never more
// than the time between them in which it did not run. A thread that was ready at both and did not
// run in between has waited all the time, although the kernel has not counted it yet. nullopt for a
// thread that is not in `after`.
std::optional<Duration> ThreadWait(const ProcessSample& before, const ProcessSample& after,
                                   pid_t tid);

// The wait of the thread that waited longest. Of a process that was silent between the looks: near
// the time between them means that it may have been starved, little means that it was not and
// hangs. Where it is known which thread was silent, ThreadWait() of that one says it more surely:
// others of the process may compute all the time and wait for each other.
Duration LongestWait(const ProcessSample& before, const ProcessSample& after);

enum class ProcessRunState {
  kRunning,  // at least one thread runs or could: it sleeps, or waits for the disk
  kStopped,  // every thread is, by SIGSTOP or the like; SIGCONT lets it go on
  kTraced,   // every thread is, some by a debugger
  kGone,     // it has ended, though its parent may not have reaped it yet
};

// nullopt when there is such a process, but /proc does not show it to us.
std::optional<ProcessRunState> RunStateOf(pid_t pid);

}  // namespace musher::transport
