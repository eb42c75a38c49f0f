// The second host of a robot: its own network and processes, which all end with it.
//
//   fault_injection_host FOLDER
//
// Prints "ready" when its namespaces exist, waits for FOLDER/go, starts the actuators, and restarts
// each one that ends. SIGUSR1 to its init reboots the host: all processes are killed,
// the boot id is another, and the boot clock starts again, earlier than at the boot before.

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "musher/test/fault_injection/host/far_host.hpp"
#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/fault_injection/robot/members.hpp"

namespace musher::fault_injection {
namespace {

namespace fs = std::filesystem;

constexpr int kPollMs = 5;

// The boot clock of each boot begins kClockStepS before that of the boot before. That of boot 0 is
// this machine's own.
constexpr long kFirstClockS = 100;
constexpr long kClockStepS = 10;

struct Boot {
  int number = 0;
  long at_s = 0;  // by this machine's boot clock
};

long SecondsSinceBoot() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return now.tv_sec;
}

constexpr const char* kBootIdFile = "/proc/sys/kernel/random/boot_id";

void SetBootId(const fs::path& folder, int boot) {
  char id[64];
  std::snprintf(id, sizeof(id), "00000000-0000-0000-0000-%012d", boot);
  std::ofstream(folder / "boot_id") << id << std::endl;
}

// Gives this process a boot clock that has just begun. Without it the next incarnations are larger
// than those before, and the run tests less.
void StartBootClock(const Boot& boot) {
  const long begun = std::max(1L, kFirstClockS - kClockStepS * boot.number);
  if (unshare(CLONE_NEWTIME) != 0) return std::perror("no time namespace");
  std::ofstream("/proc/self/timens_offsets") << "boottime " << begun - boot.at_s << " 0\n";
  const int clocks = open("/proc/self/ns/time_for_children", O_RDONLY | O_CLOEXEC);
  if (setns(clocks, CLONE_NEWTIME) != 0) std::perror("no clock of its own");
  close(clocks);
}

pid_t Start(const Member& member, const fs::path& folder, const Boot& boot) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  setsid();
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  setenv("MUSHER_ACTUATOR", member.name.c_str(), 1);
  const int log = open((folder / (member.name + ".log")).c_str(),
                       O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  if (boot.number > 0) StartBootClock(boot);
  std::vector<std::string> words =
      CommandOf(member, folder, fs::path(benchmark::Program("musher")).parent_path());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
  _exit(127);
}

// The init of the host's processes, which adopts their orphans.
[[noreturn]] void Init(const fs::path& folder) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
  mount("proc", "/proc", "proc", 0, nullptr);
  SetBootId(folder, 0);
  mount((folder / "boot_id").c_str(), kBootIdFile, nullptr, MS_BIND, nullptr);
  fs::create_directories(folder / "disk");  // hosts have disks of their own
  MountMemory(folder / "disk", 16 << 10);
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGCHLD, SIGUSR1}) sigaddset(&signals, signal);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  BringUp("lo");
  std::puts("ready");
  std::fflush(stdout);
  while (!fs::exists(folder / "go")) poll(nullptr, 0, kPollMs);
  std::map<pid_t, const Member*> members;
  Boot boot;
  const auto start_all = [&] {
    for (const Member& member : Members()) {
      if (!IsOnBoard(member, Shape::kTwoHosts)) continue;
      members[Start(member, folder, boot)] = &member;
    }
  };
  start_all();
  while (true) {
    if (sigwaitinfo(&signals, nullptr) == SIGUSR1) {
      members.clear();
      kill(-1, SIGKILL);  // all of this pid namespace but its init
      while (waitpid(-1, nullptr, 0) > 0) {
      }
      boot = {boot.number + 1, SecondsSinceBoot()};
      SetBootId(folder, boot.number);
      start_all();
    }
    for (pid_t ended = 0; (ended = waitpid(-1, nullptr, WNOHANG)) > 0;) {
      const auto member = members.extract(ended);
      if (member.empty()) continue;
      poll(nullptr, 0, kFarRestartMs);
      members[Start(*member.mapped(), folder, boot)] = member.mapped();
    }
  }
}

int Main(const fs::path& folder) {
  if (unshare(CLONE_NEWNET | CLONE_NEWPID | CLONE_NEWNS) != 0) {
    std::perror("fault_injection_host");
    return EXIT_FAILURE;
  }
  const pid_t init = fork();
  if (init == 0) Init(folder);
  int status = 0;
  waitpid(init, &status, 0);
  return EXIT_FAILURE;  // it does not end by itself
}

}  // namespace
}  // namespace musher::fault_injection

int main(int argc, char** argv) {
  if (argc != 2) return EXIT_FAILURE;
  return musher::fault_injection::Main(argv[1]);
}
