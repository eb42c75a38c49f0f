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

// "<tid> (<name>) <state> ...": R, S, D, T and so on; 0 if there is no such thread. Only the name
// may contain spaces and parentheses.
char ReadState(int tasks, pid_t tid) {
  const SmallFile file(tasks, tid, "stat");
  const std::size_t name_end = file.text().rfind(") ");
  if (name_end == std::string_view::npos || name_end + 2 >= file.text().size()) return 0;
  return file.text()[name_end + 2];
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

std::optional<ProcessSample> SampleProcess(pid_t pid, Time now) {
  const Folder tasks = TasksOf(pid);
  if (!tasks) return std::nullopt;
  ProcessSample sample{now, {}, ThrottledTime(pid)};
  while (const pid_t tid = NextTask(tasks.get())) {
    // Reads the state before the time: a thread that gets a CPU in between then counts as having
    // run.
    const char state = ReadState(dirfd(tasks.get()), tid);
    const auto cpu = ReadCpuTime(dirfd(tasks.get()), tid);
    if (cpu && !HasEnded(state)) sample.threads[tid] = {*cpu, state == 'R'};
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

Duration LongestWaitOfBoth(const ProcessSamples& sender, const ProcessSamples& receiver) {
  const Duration both =
      LongestWait(sender.before, sender.after) + LongestWait(receiver.before, receiver.after);
  return std::min(both, sender.after.at - sender.before.at);
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
