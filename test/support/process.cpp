#include "musher/test/support/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace musher::testing {
namespace {

constexpr int kWaitLimitMs = 30'000;  // between two pieces of output

// Its offset is the child's too, and stays where it is.
std::string Content(int file) {
  std::string content;
  std::array<char, 4096> part{};
  for (ssize_t size = 0;
       (size = pread(file, part.data(), part.size(), static_cast<off_t>(content.size()))) > 0;) {
    content.append(part.data(), static_cast<std::size_t>(size));
  }
  return content;
}

}  // namespace

Process::Process(const std::vector<std::string>& argv) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
  out_ = ends[0];
  err_ = memfd_create("stderr", MFD_CLOEXEC);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err_, STDERR_FILENO);
  std::vector<char*> words;
  for (const std::string& word : argv) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  const int error = posix_spawnp(&pid_, words[0], &actions, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (error != 0) throw std::runtime_error("cannot run " + argv[0]);
}

Process::~Process() {
  if (pid_ != 0) {
    Signal(SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (out_ >= 0) close(out_);
  close(err_);
}

void Process::Signal(int signal) const {
  kill(pid_, signal);
}

void Process::CloseOutput() {
  close(out_);
  out_ = -1;
}

bool Process::ReadMore() {
  if (out_ < 0) return false;
  pollfd readable{out_, POLLIN, 0};
  if (poll(&readable, 1, kWaitLimitMs) != 1) return false;
  std::array<char, 4096> part{};
  const ssize_t size = read(out_, part.data(), part.size());
  if (size <= 0) return false;
  read_.append(part.data(), size);
  return true;
}

std::string Process::LineWith(const std::string& text) {
  while (true) {
    const std::size_t end = read_.find('\n', seen_);
    if (end == std::string::npos) {
      if (!ReadMore()) return "";
      continue;
    }
    const std::string line = read_.substr(seen_, end - seen_);
    seen_ = end + 1;
    if (line.find(text) != std::string::npos) return line;
  }
}

bool Process::AwaitError(const std::string& text) const {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(kWaitLimitMs);
  while (Content(err_).find(text) == std::string::npos) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

Ended Process::Wait() {
  while (ReadMore()) {
  }
  Ended ended;
  int status = 0;
  if (waitpid(pid_, &status, 0) == pid_ && WIFEXITED(status)) ended.exit = WEXITSTATUS(status);
  pid_ = 0;
  ended.out = read_;
  ended.err = Content(err_);
  return ended;
}

Ended RunToEnd(const std::vector<std::string>& argv) {
  return Process(argv).Wait();
}

void AdoptOrphans() {
  prctl(PR_SET_CHILD_SUBREAPER, 1);
}

std::vector<pid_t> Children() {
  const std::string self = std::to_string(getpid());
  std::ifstream file("/proc/" + self + "/task/" + self + "/children");
  std::vector<pid_t> children;
  for (pid_t pid = 0; file >> pid;) children.push_back(pid);
  return children;
}

bool AwaitNoChildren() {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  for (auto children = Children(); !children.empty(); children = Children()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    for (const pid_t child : children)
      waitpid(child, nullptr, WNOHANG);  // orphans that are children of the test now
    std::this_thread::yield();
  }
  return true;
}

bool AwaitEnd(pid_t pid) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (kill(pid, 0) == 0) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    waitpid(pid, nullptr, WNOHANG);  // a child of the test now
    std::this_thread::yield();
  }
  return true;
}

void KillChildren() {
  for (auto children = Children(); !children.empty(); children = Children()) {
    for (const pid_t child : children) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
  }
}

}  // namespace musher::testing
