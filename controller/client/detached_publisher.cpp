#include "musher/controller/client/detached_publisher.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <iterator>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/base/program.hpp"

namespace musher {
namespace {

// Its two ends: to read, to write.
std::pair<UniqueFd, UniqueFd> MakePipe() {
  int ends[2] = {-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0) return {};
  return {UniqueFd(ends[0]), UniqueFd(ends[1])};
}

// By these a controller finds the processes of an actuator, to end them with it.
constexpr const char* kMarks[] = {"MUSHER_PROCESS", "MUSHER_STARTED_AS", "MUSHER_CONFIG"};

// In a forked copy, whose /proc/<pid>/environ shows its memory: each name is overwritten in its
// place.
void DropMarks() {
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view variable = *entry;
    for (const std::string_view mark : kMarks) {
      if (variable.starts_with(mark) && variable.substr(mark.size()).starts_with('=')) {
        (*entry)[0] = '_';
      }
    }
  }
}

// Processes that go on after their object: each is reaped once it has ended, with a later one.
void ReapLater(pid_t added) {
  static std::mutex mutex;
  static std::vector<pid_t>& pids = *new std::vector<pid_t>;  // used during static destruction
  const std::lock_guard lock(mutex);
  if (added > 0) pids.push_back(added);
  std::erase_if(pids, [](pid_t pid) { return waitpid(pid, nullptr, WNOHANG) != 0; });
}

}  // namespace

DetachedPublisher::DetachedPublisher(const Publish& publish, std::optional<Duration> timeout) {
  auto [read_end, write_end] = MakePipe();
  if (!read_end.valid()) return;
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) {
    DropMarks();
    write_end = {};
    PublishWhenAsked(read_end.get(), parent, timeout, publish);
  }
  if (pid_ > 0) pipe_ = std::move(write_end);
}

DetachedPublisher::DetachedPublisher(const std::vector<std::string>& program) {
  auto [read_end, write_end] = MakePipe();
  if (!read_end.valid() || program.empty()) return;
  ReapLater(0);
  const UniqueFd null(open("/dev/null", O_RDWR | O_CLOEXEC));
  ProgramSpec spec;
  spec.argv = program;
  spec.cwd = "/";  // it keeps no file system busy
  spec.without = {std::begin(kMarks), std::end(kMarks)};
  spec.input = read_end.get();
  spec.output = null.get();
  spec.after_fork = [](char* const* /*environment*/) { setsid(); };
  const auto started = ForkProgram(spec);
  if (!started) return;
  pid_ = started.value().pid();
  pipe_ = std::move(write_end);
}

DetachedPublisher::~DetachedPublisher() {
  pipe_ = {};
  ReapLater(pid_);
}

void DetachedPublisher::Cancel() {
  Send('c');
  pipe_ = {};
  if (pid_ <= 0) return;
  kill(pid_, SIGTERM);
  if (begun_) {
    ReapLater(pid_);
  } else {
    waitpid(pid_, nullptr, 0);
  }
  pid_ = -1;
}

void DetachedPublisher::PublishWhenAsked(int pipe, pid_t parent, std::optional<Duration> timeout,
                                         const Publish& publish) {
  setsid();
  // Also where a copy of the parent has the pipe: it may outlive it.
  const auto process = OpenPidfd(parent);
  const UniqueFd asks(fcntl(pipe, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
  const UniqueFd null(open("/dev/null", O_RDWR | O_CLOEXEC));
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(null.get(), stream);
  std::array<pollfd, 2> asked{pollfd{asks.get(), POLLIN, 0},
                              pollfd{process ? process.value().get() : -1, POLLIN, 0}};
  const int wait_ms = timeout ? static_cast<int>(ToMilliseconds(*timeout)) : -1;
  while (process && poll(asked.data(), asked.size(), wait_ms) < 0 && errno == EINTR) {
  }
  char word = 0;
  if (asked[0].revents != 0) {
    ssize_t size = 0;
    do {
      size = read(asks.get(), &word, 1);
    } while (size < 0 && errno == EINTR);
    if (size == 1 && word == 'c') _exit(0);
  }
  publish();
  _exit(0);
}

void DetachedPublisher::Send(char word) {
  if (!pipe_.valid() || begun_) return;
  begun_ = write(pipe_.get(), &word, 1) == 1 && word == 'p';
}

}  // namespace musher
