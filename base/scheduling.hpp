#pragma once
// The state of the threads of a process of this host, from the kernel: whether they are stopped,
// and how long they ran, waited for a CPU and waited for the disk. It distinguishes a silent
// process that got no CPU, or no page of its own program, from one that could run and hangs.
//
// The kernel counts the wait for the disk for each thread only if kernel.task_delayacct is set,
// which it is not by default. Otherwise a thread is known to have waited for the disk, but not for
// how long: at most as long as any thread of the host did (/proc/pressure/io), and at most for the
// time in which it did not run.
//
// Keeps no state and never waits; a sample reads two small files of /proc for each thread.
//
// Threads: any. Nothing throws; nullopt if something can't be read.

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <optional>

#include "musher/base/time.hpp"

namespace musher {

// Since the thread started. Both zero on a kernel built without schedstats.
struct CpuTime {
  Duration ran{};
  Duration waited{};  // ready to run, but without a CPU; counted once the wait has ended

  friend bool operator==(const CpuTime&, const CpuTime&) = default;
};

std::optional<CpuTime> ThreadCpuTime(pid_t pid, pid_t tid);

struct ThreadSample {
  CpuTime cpu;
  bool runnable = false;          // runs, or waits for a CPU
  bool blocked = false;           // sleeps uninterruptibly, as in a wait for the disk
  std::uint64_t disk_faults = 0;  // pages that were read from the disk for it
  Duration disk{};                // waited for the disk, where the kernel counts that; at its end

  friend bool operator==(const ThreadSample&, const ThreadSample&) = default;
};

// One sample of a process.
struct ProcessSample {
  Time at{};
  std::map<pid_t, ThreadSample> threads;  // by tid
  Duration throttled{};  // CPU time that the quota of its cgroup has withheld so far
  std::optional<Duration> disk_pressure{};  // see DiskPressure()
  int cpus = 1;                             // online
};

// The CPU time that the process's cgroup quota has withheld, over all CPUs; zero if there is no
// quota or it is not visible to us.
Duration ThrottledTime(pid_t pid);

// For how long since the boot a thread of this host has waited for the disk, as an average over its
// CPUs: a single thread has waited at most so long times their number. Other CPUs may have been
// online before, so only a difference counts. nullopt: the kernel does not count it.
std::optional<Duration> DiskPressure();

// nullopt if there is no such process, or all its threads have exited.
std::optional<ProcessSample> SampleProcess(pid_t pid, Time now);

// How long a thread waited for a CPU between two samples, or was throttled by a quota; never more
// than the time between them in which it did not run. A thread that was ready at both samples and
// did not run in between has waited all the time, although the kernel has not counted it yet.
// nullopt for a thread that is not in `after`.
std::optional<Duration> ThreadWait(const ProcessSample& before, const ProcessSample& after,
                                   pid_t tid);

// The wait of the thread that waited longest. For a process that was silent between the samples: a
// value near the time between them means that it may have been starved, a small value that it
// hangs. If the silent thread is known, its ThreadWait() is more reliable: other threads of the
// process may compute all the time and wait for each other.
Duration LongestWait(const ProcessSample& before, const ProcessSample& after);

// How long a thread waited for the disk between two samples, at most; zero for one that shows no
// sign of it: it is blocked at neither sample, and no page was read for it. nullopt for a thread
// that is not in `after`.
std::optional<Duration> ThreadDiskWait(const ProcessSample& before, const ProcessSample& after,
                                       pid_t tid);

struct Wait {
  Duration cpu{};
  Duration disk{};

  friend bool operator==(const Wait&, const Wait&) = default;
};

// Two samples of one process.
struct ProcessSamples {
  ProcessSample before;
  ProcessSample after;
};

// Both waits of a thread, never more than the time in which it did not run.
Wait WaitOfThread(const ProcessSamples& samples, pid_t tid);

// How long a message from the one process to the other may have waited for a CPU and the disk: the
// sum of both waits, since the receiver's begins when the sender's has ended; never more than the
// time between the samples. Which thread of the sender sends is not known: the one with the longest
// wait, of which at most `longest_disk` for the disk counts. `receiving`: the thread of the
// receiver, whose other threads may write to the disk all the time.
Wait LongestWaitOfBoth(const ProcessSamples& sender, const ProcessSamples& receiver,
                       pid_t receiving, Duration longest_disk);

enum class ProcessRunState {
  kRunning,  // at least one thread runs or could: it sleeps, or waits for the disk
  kStopped,  // every thread is stopped, by SIGSTOP or the like; SIGCONT continues it
  kTraced,   // every thread is stopped, some by a debugger
  kExited,   // it has exited, but its parent may not have reaped it yet
};

// nullopt if the process exists but is not visible to us in /proc.
std::optional<ProcessRunState> RunStateOf(pid_t pid);

}  // namespace musher
