#include "musher/cli/doctor/host_facts.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <linux/magic.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/program_path.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/cli/doctor/in_child.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kSysPtrace = 19;  // CAP_SYS_PTRACE
constexpr int kSysNice = 23;    // CAP_SYS_NICE
// The kernel gives the first pid namespace of a host always this number.
constexpr ino_t kFirstPidNamespace = 0xEFFFFFFC;

std::string FirstWord(const std::string& file) {
  std::istringstream in(ReadFile(file));
  std::string word;
  in >> word;
  return word;
}

bool IsInstalled(const std::string& program) {
  return !FindInPath(program).empty();
}

// The effective capabilities of this process.
bool HasCapability(int number) {
  std::istringstream lines(ReadFile("/proc/self/status"));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("CapEff:")) continue;
    const auto set = std::strtoull(line.c_str() + 7, nullptr, 16);
    return (set >> number & 1U) != 0;
  }
  return false;
}

// The folder of this process's cgroup (version 2) in the mounted hierarchy.
std::string CgroupFolder() {
  std::istringstream lines(ReadFile("/proc/self/cgroup"));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("0::")) return "/sys/fs/cgroup" + line.substr(3);
  }
  return "";
}

// The smallest quota of the cgroup and those above it.
std::optional<double> Quota() {
  std::optional<double> least;
  const fs::path top = "/sys/fs/cgroup";
  for (fs::path folder = CgroupFolder(); !folder.empty(); folder = folder.parent_path()) {
    std::istringstream in(ReadFile(folder / "cpu.max"));
    double quota = 0;
    double period = 0;
    if (in >> quota >> period && period > 0) {  // "max" is not a number
      least = std::min(least.value_or(quota / period), quota / period);
    }
    if (folder == top || !folder.has_relative_path()) break;
  }
  return least;
}

std::int64_t NewestFile(const std::string& folder) {
  std::int64_t newest = 0;
  for (const fs::path& file : EntriesOf(folder)) {
    struct stat info {};
    if (stat(file.c_str(), &info) == 0) newest = std::max(newest, std::int64_t{info.st_mtime});
  }
  return newest;
}

// "<existing> <is folder> <writable> <in memory> <free> <total> <inodes> <newest file>
// <device>"; the path comes last because it may contain spaces.
std::string DescribeFolder(const std::string& path) {
  std::error_code error;
  fs::path existing = path;
  while (existing.has_relative_path() && !fs::exists(existing, error)) {
    if (fs::is_symlink(existing, error)) {
      return fmt::format("error {} is a link to {}, which does not exist", existing.string(),
                         fs::read_symlink(existing, error).string());
    }
    existing = existing.parent_path();
  }
  struct statfs disk {};
  if (statfs(existing.c_str(), &disk) != 0) return "error " + SystemError("statfs").message;
  const auto block = static_cast<std::int64_t>(disk.f_bsize);
  struct stat info {};
  stat(existing.c_str(), &info);
  return fmt::format("ok {:d} {:d} {:d} {} {} {} {} {} {}", fs::is_directory(existing, error),
                     access(existing.c_str(), W_OK | X_OK) == 0, disk.f_type == TMPFS_MAGIC,
                     block * static_cast<std::int64_t>(disk.f_bavail),
                     block * static_cast<std::int64_t>(disk.f_blocks),
                     disk.f_files == 0 ? -1 : static_cast<std::int64_t>(disk.f_ffree),
                     existing == path ? NewestFile(path) : 0, info.st_dev, existing.string());
}

}  // namespace

std::optional<std::int64_t> ReadNumber(const std::string& file) {
  std::istringstream in(ReadFile(file));
  std::int64_t number = 0;
  return in >> number ? std::optional(number) : std::nullopt;
}

ClockFacts ReadClock() {
  ClockFacts clock;
  timex state{};
  const int result = adjtimex(&state);
  if (result < 0) {
    clock.error = SystemError("adjtimex").message;
  } else {
    clock.synchronised = result != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
    clock.max_error = std::chrono::microseconds(state.maxerror);
  }
  clock.source = FirstWord("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  clock.wall_s = std::chrono::duration_cast<std::chrono::seconds>(
                     std::chrono::system_clock::now().time_since_epoch())
                     .count();
  return clock;
}

Limits ReadLimits() {
  Limits limits;
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) == 0) {
    limits.files = files.rlim_cur;
    limits.files_hard = files.rlim_max;
  }
  limits.tracer = IsInstalled("eu-stack") ? "eu-stack" : IsInstalled("gdb") ? "gdb" : "";
  if (const auto scope = ReadNumber("/proc/sys/kernel/yama/ptrace_scope")) {
    limits.ptrace_scope = static_cast<int>(*scope);
  }
  limits.may_trace = HasCapability(kSysPtrace);
  rlimit real_time{};
  if (getrlimit(RLIMIT_RTPRIO, &real_time) == 0) limits.real_time = real_time.rlim_cur;
  limits.may_real_time = HasCapability(kSysNice);
  limits.lowest_nice = getpriority(PRIO_PROCESS, 0);
  rlimit nice{};  // counts down from 20
  if (getrlimit(RLIMIT_NICE, &nice) == 0) {
    const auto steps = static_cast<int>(std::min<rlim_t>(nice.rlim_cur, 40));
    limits.lowest_nice = std::min(limits.lowest_nice, 20 - steps);
  }
  return limits;
}

CoreFacts ReadCore() {
  CoreFacts core;
  rlimit size{};
  if (getrlimit(RLIMIT_CORE, &size) == 0) {
    core.limit = size.rlim_cur;
    core.limit_hard = size.rlim_max;
  }
  std::istringstream in(ReadFile("/proc/sys/kernel/core_pattern"));
  std::getline(in, core.pattern);
  if (core.pattern.starts_with('|')) {
    // In a container the program is the host's, and not visible.
    struct stat space {};
    const bool on_host =
        stat("/proc/self/ns/pid", &space) == 0 && space.st_ino == kFirstPidNamespace;
    const std::string program = core.pattern.substr(1, core.pattern.find(' ') - 1);
    if (on_host && access(program.c_str(), X_OK) != 0) core.obstacle = "it does not exist";
  } else if (core.pattern.starts_with('/')) {
    const std::string folder = core.pattern.substr(0, core.pattern.rfind('/'));
    const bool known = folder.find('%') == std::string::npos;  // the same for every process
    if (known && access((folder + "/").c_str(), W_OK | X_OK) != 0) {
      core.obstacle = errno == ENOENT ? "the folder does not exist"
                                      : "the folder is not writable for this user";
    }
  }
  return core;
}

CpuFacts ReadCpu() {
  CpuFacts cpu;
  cpu_set_t usable;
  CPU_ZERO(&usable);
  if (sched_getaffinity(0, sizeof usable, &usable) == 0) cpu.cpus = CPU_COUNT(&usable);
  cpu.quota = Quota();
  cpu.throttled = ThrottledTime(getpid());
  return cpu;
}

FolderFacts ReadFolder(const std::string& path, Duration timeout, std::int64_t& newest_file_s) {
  FolderFacts folder;
  folder.path = folder.existing = path;
  const Time deadline = std::chrono::steady_clock::now() + timeout;
  auto child = InChild::Start([&path] { return DescribeFolder(path); });
  const auto text = child ? child.value().Await(deadline) : Result<std::string>(child.error());
  if (!text) {
    folder.error = fmt::format("the disk did not answer within {} ms", ToMilliseconds(timeout));
    return folder;
  }
  std::istringstream in(text.value());
  std::string outcome;
  in >> outcome >> folder.is_folder >> folder.writable >> folder.in_memory >> folder.free_bytes >>
      folder.total_bytes >> folder.free_inodes >> newest_file_s >> folder.device;
  if (outcome != "ok") folder.error = text.value().substr(outcome.size() + 1);
  if (in) std::getline(in >> std::ws, folder.existing);
  return folder;
}

}  // namespace musher::cli
