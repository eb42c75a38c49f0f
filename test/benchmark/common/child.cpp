#include "musher/test/benchmark/common/child.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "musher/test/support/domain.hpp"

namespace musher::benchmark {
namespace {

std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> Merged(const Child::Environment& env) {
  std::vector<std::string> merged;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (env.count(text.substr(0, text.find('='))) == 0) merged.push_back(text);
  }
  for (const auto& [key, value] : env) merged.push_back(key + '=' + value);
  return merged;
}

}  // namespace

Child::Child(const std::vector<std::string>& argv, const Environment& env, Output output) {
  std::vector<std::string> arguments = argv;
  std::vector<std::string> variables = Merged(env);
  const std::vector<char*> argument_pointers = Pointers(arguments);
  const std::vector<char*> variable_pointers = Pointers(variables);
  int ends[2] = {-1, -1};
  if (output == Output::kPiped && pipe2(ends, O_CLOEXEC) != 0) Fail("pipe");
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) Fail("fork");
  if (pid_ > 0) {
    pipe_ = ends[0];
    if (ends[1] >= 0) close(ends[1]);
    return;
  }
  // In the child, only calls that are safe after a fork with threads.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(EXIT_FAILURE);
  if (output == Output::kPiped) dup2(ends[1], STDOUT_FILENO);
  if (output == Output::kNowhere) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  syscall(SYS_close_range, STDERR_FILENO + 1, ~0U, 0);  // DDS leaves its sockets open for us
  execve(argument_pointers[0], argument_pointers.data(), variable_pointers.data());
  _exit(127);
}

Child::Child(Child&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)), pipe_(std::exchange(other.pipe_, -1)) {}

Child::~Child() {
  if (pipe_ >= 0) close(pipe_);
  if (pid_ == 0) return;
  kill(pid_, SIGKILL);
  Wait();
}

int Child::Wait() {
  int status = 0;
  waitpid(std::exchange(pid_, 0), &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void Child::AwaitOutput() const {
  char byte = 0;
  if (read(pipe_, &byte, 1) != 1) Fail("a program has ended without a word");
}

std::string Program(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

void Fail(const std::string& why) {
  std::fprintf(stderr, "benchmark failed: %s (%s)\n", why.c_str(), std::strerror(errno));
  std::exit(EXIT_FAILURE);
}

void DieWithParent() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
}

int Domain(int number) {
  constexpr int kMost = 60;  // the others are for the tests beside us
  number %= kMost;
  static std::map<int, transport::LockedDomain> taken;
  if (!taken.contains(number)) {
    taken.emplace(number, transport::LockFreeDomain(getpid() * 8 + number));
  }
  return taken.at(number).id;
}

int NextDomain() {
  static int number = 0;
  const int domain = Domain(number++);
  setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), 1);
  return domain;
}

}  // namespace musher::benchmark
