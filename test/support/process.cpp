#include "musher/test/support/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/inotify.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "musher/base/host.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::testing {
namespace {

constexpr auto kOutputLimit = std::chrono::seconds(120);  // between two pieces of output
constexpr auto kEndLimit = std::chrono::seconds(60);

// A file that goes with its last descriptor; `changes` becomes readable when it is written to.
int OpenNamelessFile(int changes) {
  std::string path = (std::filesystem::temp_directory_path() / "musher-test-XXXXXX").string();
  const int file = mkostemp(path.data(), O_CLOEXEC);
  if (file < 0) throw std::runtime_error("mkostemp");
  inotify_add_watch(changes, path.c_str(), IN_MODIFY);
  unlink(path.c_str());
  return file;
}

// A child has been reaped then.
bool AwaitEndUntil(Time deadline, pid_t pid) {
  if (const auto process = OpenPidfd(pid)) {
    if (!AwaitReadable(process.value().get(), deadline)) return false;
  }
  waitpid(pid, nullptr, WNOHANG);
  return true;
}

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
  err_changes_ = inotify_init1(IN_CLOEXEC);
  err_ = OpenNamelessFile(err_changes_);
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
  close(err_changes_);
}

void Process::Signal(int signal) const {
  kill(pid_, signal);
}

void Process::CloseOutput() {
  close(out_);
  out_ = -1;
}

bool Process::ReadMore(Time deadline) {
  if (out_ < 0 || !AwaitReadable(out_, deadline)) return false;
  std::array<char, 4096> part{};
  const ssize_t size = read(out_, part.data(), part.size());
  if (size <= 0) return false;
  read_.append(part.data(), size);
  return true;
}

std::optional<std::string> Process::NextLine(Time deadline) {
  std::size_t end = 0;
  while ((end = read_.find('\n', seen_)) == std::string::npos) {
    if (!ReadMore(deadline)) return std::nullopt;
  }
  std::string line = read_.substr(seen_, end - seen_);
  seen_ = end + 1;
  return line;
}

std::string Process::LineWith(const std::string& text) {
  while (auto line = NextLine(In(kOutputLimit))) {
    if (line->find(text) != std::string::npos) return *std::move(line);
  }
  return "";
}

bool Process::AwaitError(const std::string& text) const {
  const Time deadline = In(kOutputLimit);
  while (Content(err_).find(text) == std::string::npos) {
    if (!AwaitReadable(err_changes_, deadline)) return false;
    std::array<char, 4096> events{};
    if (read(err_changes_, events.data(), events.size()) < 0) return false;
  }
  return true;
}

Ended Process::Wait() {
  while (ReadMore(In(kOutputLimit))) {
  }
  Ended ended;
  int status = 0;
  if (waitpid(pid_, &status, 0) == pid_) {
    if (WIFEXITED(status)) ended.exit = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) ended.signal = WTERMSIG(status);
  }
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

bool AwaitEnd(pid_t pid) {
  return AwaitEndUntil(In(kEndLimit), pid);
}

// What a child leaves behind is a child of this process then.
bool AwaitNoChildren() {
  const Time deadline = In(kEndLimit);
  for (auto children = Children(); !children.empty(); children = Children()) {
    for (const pid_t child : children) {
      if (!AwaitEndUntil(deadline, child)) return false;
    }
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
