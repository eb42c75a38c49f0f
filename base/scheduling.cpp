#include "musher/base/scheduling.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>

#include "musher/base/files.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {
namespace {

struct CloseFolder {
  void operator()(DIR* folder) const { closedir(folder); }
};
using Folder = std::unique_ptr<DIR, CloseFolder>;

Folder TasksOf(pid_t pid) {
  std::array<char, 32> path{};
  std::snprintf(path.data(), path.size(), "/proc/%d/task", pid);
  return Folder(opendir(path.data()));
}

// The next thread of the folder; 0 at the end.
pid_t NextTask(DIR* tasks) {
  while (const dirent* entry =
             readdir(tasks)) {  // NOLINT(concurrency-mt-unsafe): the folder is ours
    const pid_t tid = std::atoi(entry->d_name);
    if (tid > 0) return tid;  // not "." and ".."
  }
  return 0;
}

// A small file of /proc, cut to the buffer.
class SmallFile {
 public:
  SmallFile(int folder, pid_t tid, const char* name) {
    std::array<char, 64> path{};
    std::snprintf(path.data(), path.size(), "%d/%s", tid, name);
    const UniqueFd file(openat(folder, path.data(), O_RDONLY | O_CLOEXEC));
    if (!file.valid()) return;
    const ssize_t size = read(file.get(), buffer_.data(), buffer_.size());
    text_ = std::string_view(buffer_.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  }
  SmallFile(const SmallFile&) = delete;
  SmallFile& operator=(const SmallFile&) = delete;

  std::string_view text() const { return text_; }

 private:
  std::array<char, 512> buffer_;
  std::string_view text_;
};

// "<ran ns> <waited ns> <slices>"
std::optional<CpuTime> ReadCpuTime(int tasks, pid_t tid) {
  const SmallFile file(tasks, tid, "schedstat");
  const char* const end = file.text().data() + file.text().size();
  std::int64_t ran = 0;
  std::int64_t waited = 0;
  const auto first = std::from_chars(file.text().data(), end, ran);
  if (first.ec != std::errc() || first.ptr == end) return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, waited);
  if (second.ec != std::errc()) return std::nullopt;
  return CpuTime{Duration(ran), Duration(waited)};
}

struct Stat {
  char state = 0;                 // R, S, D, T and so on; 0: there is no such thread
  std::uint64_t disk_faults = 0;  // "majflt"
  Duration disk{};  // "delayacct_blkio_ticks"; zero: it did not wait, or is not counted
};

// "<tid> (<name>) <state> ...". Only the name may contain spaces and parentheses.
Stat ReadStat(int tasks, pid_t tid) {
  // Counted from the state, which is the third field of the line.
  constexpr int kDiskFaults = 9;
  constexpr int kDiskTicks = 39;
  const SmallFile file(tasks, tid, "stat");
  const std::size_t name_end = file.text().rfind(") ");
  if (name_end == std::string_view::npos || name_end + 2 >= file.text().size()) return {};
  std::string_view rest = file.text().substr(name_end + 2);
  Stat stat;
  stat.state = rest.front();
  for (int i = 1; i <= kDiskTicks; ++i) {
    const std::size_t space = rest.find(' ');
    if (space == std::string_view::npos) break;
    rest.remove_prefix(space + 1);
    if (i != kDiskFaults && i != kDiskTicks) continue;
    std::uint64_t number = 0;
    std::from_chars(rest.data(), rest.data() + rest.size(), number);
    if (i == kDiskFaults) stat.disk_faults = number;
    if (i == kDiskTicks) {
      const auto ticks_per_s = static_cast<std::uint64_t>(std::max(sysconf(_SC_CLK_TCK), 1L));
      stat.disk = Milliseconds(static_cast<std::int64_t>(number * 1000 / ticks_per_s));
    }
  }
  return stat;
}

char ReadState(int tasks, pid_t tid) {
  return ReadStat(tasks, tid).state;
}

// Between two samples, in which it ran for a part of the time.
Duration NotRunning(const ProcessSample& before, const ProcessSample& after,
                    const ThreadSample& then, const ThreadSample& now) {
  return std::max(after.at - before.at - (now.cpu.ran - then.cpu.ran), Duration::zero());
}

ThreadSample SampleOf(const ProcessSample& sample, pid_t tid) {
  const auto found = sample.threads.find(tid);
  return found == sample.threads.end() ? ThreadSample{} : found->second;
}

// The number after `key` in a file of "<key> <number>" lines.
std::optional<std::int64_t> NumberOf(std::string_view key, const std::string& text) {
  std::istringstream lines(text);
  std::string name;
  std::int64_t number = 0;
  while (lines >> name >> number) {
    if (name == key) return number;
  }
  return std::nullopt;
}

bool HasEnded(char state) {
  return state == 0 || state == 'Z' || state == 'X';
}

}  // namespace

std::optional<CpuTime> ThreadCpuTime(pid_t pid, pid_t tid) {
  const Folder tasks = TasksOf(pid);
  if (!tasks) return std::nullopt;
  return ReadCpuTime(dirfd(tasks.get()), tid);
}

// Lines of /proc/<pid>/cgroup: "<number>:<controllers>:<path>", for version 2 "0::<path>".
Duration ThrottledTime(pid_t pid) {
  std::istringstream lines(ReadFile("/proc/" + std::to_string(pid) + "/cgroup"));
  Duration throttled{};
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const std::string path = line.substr(second + 1) + "/cpu.stat";
    if (controllers.empty()) {
      const auto us = NumberOf("throttled_usec", ReadFile("/sys/fs/cgroup" + path));
      throttled += std::chrono::microseconds(us.value_or(0));
    } else if (("," + controllers + ",").find(",cpu,") != std::string::npos) {
      const auto ns = NumberOf("throttled_time", ReadFile("/sys/fs/cgroup/cpu" + path));
      throttled += Duration(ns.value_or(0));
    }
  }
  return throttled;
}

// "some avg10=… avg60=… avg300=… total=<us>" in the first line: the average over the CPUs that are
// not idle, so one thread that waits on one of several CPUs counts for a part of the time.
std::optional<Duration> DiskPressure() {
  const std::string text = ReadFile("/proc/pressure/io");
  constexpr std::string_view kTotal = "total=";
  const std::size_t at = text.find(kTotal);
  if (!text.starts_with("some ") || at == std::string::npos) return std::nullopt;
  std::int64_t total_us = 0;
  const char* const end = text.data() + text.size();
  if (std::from_chars(text.data() + at + kTotal.size(), end, total_us).ec != std::errc()) {
    return std::nullopt;
  }
  return std::chrono::microseconds(total_us);
}

std::optional<ProcessSample> SampleProcess(pid_t pid, Time now) {
  const Folder tasks = TasksOf(pid);
  if (!tasks) return std::nullopt;
  ProcessSample sample{now, {}, ThrottledTime(pid), DiskPressure()};
  sample.cpus = static_cast<int>(std::max(sysconf(_SC_NPROCESSORS_ONLN), 1L));
  while (const pid_t tid = NextTask(tasks.get())) {
    // Reads the state before the time: a thread that gets a CPU in between then counts as having
    // run.
    const Stat stat = ReadStat(dirfd(tasks.get()), tid);
    const auto cpu = ReadCpuTime(dirfd(tasks.get()), tid);
    if (!cpu || HasEnded(stat.state)) continue;
    sample.threads[tid] = {*cpu, stat.state == 'R', stat.state == 'D', stat.disk_faults, stat.disk};
  }
  if (sample.threads.empty()) return std::nullopt;
  return sample;
}

std::optional<Duration> ThreadWait(const ProcessSample& before, const ProcessSample& after,
                                   pid_t tid) {
  const auto now = after.threads.find(tid);
  if (now == after.threads.end()) return std::nullopt;
  const Duration between = after.at - before.at;
  const auto found = before.threads.find(tid);
  const ThreadSample then = found == before.threads.end() ? ThreadSample{} : found->second;
  if (now->second.runnable && now->second == then) return between;
  const Duration waited = now->second.cpu.waited - then.cpu.waited;
  // A quota that withholds two CPUs at once counts twice; the time in which a thread ran is
  // excluded.
  const Duration most = between - (now->second.cpu.ran - then.cpu.ran);
  return std::max(std::min(std::max(waited, after.throttled - before.throttled), most),
                  Duration::zero());
}

Duration LongestWait(const ProcessSample& before, const ProcessSample& after) {
  Duration longest{};
  for (const auto& [tid, thread] : after.threads) {
    longest = std::max(longest, ThreadWait(before, after, tid).value_or(Duration::zero()));
  }
  return longest;
}

std::optional<Duration> ThreadDiskWait(const ProcessSample& before, const ProcessSample& after,
                                       pid_t tid) {
  const auto found = after.threads.find(tid);
  if (found == after.threads.end()) return std::nullopt;
  const ThreadSample& now = found->second;
  const ThreadSample then = SampleOf(before, tid);
  const Duration most = NotRunning(before, after, then, now);
  Duration waited = std::max(now.disk - then.disk, Duration::zero());
  // A wait is counted at its end, if at all.
  if (then.blocked || now.blocked || now.disk_faults > then.disk_faults) {
    const bool limited = before.disk_pressure && after.disk_pressure;
    const int cpus = std::max(before.cpus, after.cpus);
    waited =
        std::max(waited, limited ? (*after.disk_pressure - *before.disk_pressure) * cpus : most);
  }
  return std::min(waited, most);
}

Wait WaitOfThread(const ProcessSamples& samples, pid_t tid) {
  const auto& [before, after] = samples;
  const Duration most = NotRunning(before, after, SampleOf(before, tid), SampleOf(after, tid));
  Wait wait;
  wait.cpu = ThreadWait(before, after, tid).value_or(Duration::zero());
  const Duration left = std::max(most - wait.cpu, Duration::zero());
  wait.disk = std::min(ThreadDiskWait(before, after, tid).value_or(Duration::zero()), left);
  return wait;
}

Wait LongestWaitOfBoth(const ProcessSamples& sender, const ProcessSamples& receiver,
                       pid_t receiving, Duration longest_disk) {
  const auto counted = [&](const Wait& wait) {
    return wait.cpu + std::min(wait.disk, longest_disk);
  };
  Wait both;
  for (const auto& [tid, thread] : sender.after.threads) {
    const Wait wait = WaitOfThread(sender, tid);
    if (counted(wait) > counted(both)) both = wait;
  }
  const Duration between = sender.after.at - sender.before.at;
  both.cpu = std::min(both.cpu + LongestWait(receiver.before, receiver.after), between);
  both.disk = std::min(both.disk + WaitOfThread(receiver, receiving).disk, between - both.cpu);
  return both;
}

std::optional<ProcessRunState> RunStateOf(pid_t pid) {
  const Folder tasks = TasksOf(pid);
  if (!tasks) {
    if (kill(pid, 0) != 0 && errno == ESRCH) return ProcessRunState::kExited;
    return std::nullopt;
  }
  bool alive = false;
  bool traced = false;
  while (const pid_t tid = NextTask(tasks.get())) {
    const char state = ReadState(dirfd(tasks.get()), tid);
    if (HasEnded(state)) continue;
    if (state != 'T' && state != 't') return ProcessRunState::kRunning;
    alive = true;
    traced = traced || state == 't';
  }
  if (!alive) return ProcessRunState::kExited;
  return traced ? ProcessRunState::kTraced : ProcessRunState::kStopped;
}

}  // namespace musher
