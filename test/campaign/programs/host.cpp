// The second host of a robot: its own network and processes, which all end with it.
//
//   campaign_host FOLDER
//
// Says a word when its namespaces are there, waits for FOLDER/go, starts the actuators, and starts
// again whichever ends.

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "musher/test/campaign/host/far_host.hpp"
#include "musher/test/campaign/host/isolation.hpp"
#include "musher/test/campaign/robot/crew.hpp"

namespace musher::campaign {
namespace {

namespace fs = std::filesystem;

constexpr int kPollMs = 5;

pid_t Start(const Member& member, const fs::path& folder) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  setsid();
  setenv("MUSHER_ACTUATOR", member.name.c_str(), 1);
  const int log = open((folder / (member.name + ".log")).c_str(),
                       O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  std::vector<std::string> words =
      CommandOf(member, folder, fs::path(benchmark::Program("musher")).parent_path());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
  _exit(127);
}

// As init of its processes: theirs that are orphaned are its own.
[[noreturn]] void Init(const fs::path& folder) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
  mount("proc", "/proc", "proc", 0, nullptr);
  BringUp("lo");
  std::puts("ready");
  std::fflush(stdout);
  while (!fs::exists(folder / "go")) poll(nullptr, 0, kPollMs);
  std::map<pid_t, const Member*> members;
  for (const Member& member : Crew()) members[Start(member, folder)] = &member;
  while (true) {
    const pid_t ended = waitpid(-1, nullptr, 0);
    const auto member = members.extract(ended);
    if (member.empty()) continue;
    poll(nullptr, 0, kFarRestartMs);
    members[Start(*member.mapped(), folder)] = member.mapped();
  }
}

int Main(const fs::path& folder) {
  if (unshare(CLONE_NEWNET | CLONE_NEWPID | CLONE_NEWNS) != 0) {
    std::perror("campaign_host");
    return EXIT_FAILURE;
  }
  const pid_t init = fork();
  if (init == 0) Init(folder);
  int status = 0;
  waitpid(init, &status, 0);
  return EXIT_FAILURE;  // it does not end by itself
}

}  // namespace
}  // namespace musher::campaign

int main(int argc, char** argv) {
  if (argc != 2) return EXIT_FAILURE;
  return musher::campaign::Main(argv[1]);
}
