#include "musher/controller/client/detached_publisher.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <iterator>
#include <mutex>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/base/program.hpp"
#include "musher/transport/network.hpp"

namespace musher {
namespace {

// The two ends of a channel: for the new process, and for its program. Packets keep their bounds,
// and a packet to a process that has ended raises no signal.
std::pair<UniqueFd, UniqueFd> MakeChannel() {
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return {};
  return {UniqueFd(ends[0]), UniqueFd(ends[1])};
}

// The first byte of a packet; a note follows it.
constexpr char kPublish = 'p';
constexpr char kCancel = 'c';
constexpr char kNote = 'n';

constexpr Duration kLongestEnd = std::chrono::seconds(1);  // of a process that is cancelled

// Waits until the process is to publish, or is cancelled. Returns whether it is to publish. `ended`
// becomes readable when the program ends, even while a copy of the program has the channel open;
// -1: the program has ended.
bool IsToPublish(int channel, int ended, std::optional<Duration> timeout,
                 DetachedPublisher::Notes& notes) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begun = Clock::now();
  bool over = ended < 0;
  while (true) {
    std::array<char, 1 + DetachedPublisher::kLongestNote> packet{};
    const ssize_t size = recv(channel, packet.data(), packet.size(), MSG_DONTWAIT);
    if (size > 0 && packet[0] != kNote) return packet[0] != kCancel;
    if (size > 0) {
      notes.emplace_back(packet.data() + 1, static_cast<std::size_t>(size) - 1);
      continue;
    }
    if (size == 0) return true;
    if (errno == EINTR) continue;
    if (errno != EAGAIN || over) return true;
    const Duration left = timeout.value_or(Duration{}) - (Clock::now() - begun);
    if (timeout && left <= Duration{}) return true;
    std::array<pollfd, 2> awaited{pollfd{channel, POLLIN, 0}, pollfd{ended, POLLIN, 0}};
    const int wait_ms = timeout ? static_cast<int>(ToMilliseconds(left)) + 1 : -1;
    if (poll(awaited.data(), awaited.size(), wait_ms) > 0) over = awaited[1].revents != 0;
  }
}

// Each address by which other hosts may be reached: "wlan0 10.0.0.7".
std::set<std::string> OuterAddresses() {
  std::set<std::string> addresses;
  for (const transport::NetworkInterface& one : transport::ReadInterfaces()) {
    if (!one.up || one.loopback) continue;
    for (const std::string& address : one.addresses) addresses.insert(one.name + " " + address);
  }
  return addresses;
}

// The processes by which the stop is published.
class Copies {
 public:
  Copies(const DetachedPublisher::Publish& publish, const DetachedPublisher::Notes& notes)
      : publish_(publish), notes_(notes) {}
  ~Copies() {
    for (const pid_t pid : pids_) End(pid);
  }
  Copies(const Copies&) = delete;
  Copies& operator=(const Copies&) = delete;

  // Starts a copy if none runs, or if a network has come up. The copy before keeps running: a robot
  // may have discovered that copy alone.
  void Update() {
    std::set<std::string> present = OuterAddresses();
    if (!pids_.empty() && std::ranges::includes(joined_, present)) return;
    if (pids_.size() > 1) {
      End(pids_.front());
      pids_.erase(pids_.begin());
    }
    joined_ = std::move(present);
    if (const pid_t pid = Begin(); pid > 0) pids_.push_back(pid);
  }
  // Whether a copy has ended because the stop is released.
  bool Released() {
    bool released = false;
    std::erase_if(pids_, [&released](pid_t pid) {
      int status = 0;
      if (waitpid(pid, &status, WNOHANG) != pid) return false;
      released = released || (WIFEXITED(status) && WEXITSTATUS(status) == 0);
      return true;
    });
    return released;
  }

 private:
  pid_t Begin() const {
    const pid_t own = getpid();
    const pid_t pid = fork();
    if (pid != 0) return pid;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    _exit(getppid() == own && publish_(notes_) ? 0 : 1);
  }
  static void End(pid_t pid) {
    kill(pid, SIGKILL);
    waitpid(pid, nullptr, 0);
  }

  const DetachedPublisher::Publish& publish_;
  const DetachedPublisher::Notes& notes_;
  std::vector<pid_t> pids_;  // the newest last
  std::set<std::string> joined_;
};

void PublishForAMinute(const DetachedPublisher::Publish& publish,
                       const DetachedPublisher::Notes& notes) {
  constexpr int kLookMs = 200;
  const auto begun = std::chrono::steady_clock::now();
  Copies copies(publish, notes);
  do {
    copies.Update();
    poll(nullptr, 0, kLookMs);
  } while (!copies.Released() &&
           std::chrono::steady_clock::now() - begun < DetachedPublisher::kKeptPublished);
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
  auto [of_process, of_program] = MakeChannel();
  if (!of_process.valid()) return;
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) {
    DropMarks();
    of_program = {};
    PublishWhenAsked(of_process.get(), parent, timeout, publish);
  }
  if (pid_ > 0) channel_ = std::move(of_program);
}

DetachedPublisher::DetachedPublisher(const std::vector<std::string>& program) {
  auto [of_process, of_program] = MakeChannel();
  if (!of_process.valid() || program.empty()) return;
  ReapLater(0);
  const UniqueFd null(open("/dev/null", O_RDWR | O_CLOEXEC));
  ProgramSpec spec;
  spec.argv = program;
  spec.cwd = "/";  // it keeps no file system busy
  spec.without = {std::begin(kMarks), std::end(kMarks)};
  spec.input = of_process.get();
  spec.output = null.get();
  spec.after_fork = [](char* const* /*environment*/) { setsid(); };
  const auto started = ForkProgram(spec);
  if (!started) return;
  pid_ = started.value().pid();
  channel_ = std::move(of_program);
}

DetachedPublisher::~DetachedPublisher() {
  channel_ = {};
  ReapLater(pid_);
}

void DetachedPublisher::Note(std::string_view note) {
  if (note.size() <= kLongestNote) Send(kNote + std::string(note));
}

void DetachedPublisher::Begin() {
  Send({kPublish});
}

// A process that waits for a disk may not end soon, and nothing waits for it.
void DetachedPublisher::Cancel() {
  Send({kCancel});
  channel_ = {};
  if (pid_ <= 0) return;
  kill(pid_, SIGTERM);
  if (const auto process = OpenPidfd(pid_)) {
    pollfd ended{process.value().get(), POLLIN, 0};
    poll(&ended, 1, static_cast<int>(ToMilliseconds(kLongestEnd)));
  }
  ReapLater(std::exchange(pid_, -1));
}

void DetachedPublisher::PublishWhenAsked(int channel, pid_t parent, std::optional<Duration> timeout,
                                         const Publish& publish) {
  setsid();
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  sigprocmask(SIG_UNBLOCK, &end, nullptr);
  std::signal(SIGTERM, SIG_DFL);
  const auto process = OpenPidfd(parent);
  const UniqueFd kept(fcntl(channel, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
  const UniqueFd null(open("/dev/null", O_RDWR | O_CLOEXEC));
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(null.get(), stream);
  Notes notes;
  if (IsToPublish(kept.get(), process ? process.value().get() : -1, timeout, notes)) {
    PublishForAMinute(publish, notes);
  }
  _exit(0);
}

void DetachedPublisher::Send(const std::string& packet) {
  if (!channel_.valid()) return;
  send(channel_.get(), packet.data(), packet.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

}  // namespace musher
