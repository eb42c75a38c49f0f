#include "musher/controller/process/host_bus.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include "musher/base/exit_status.hpp"
#include "musher/base/host.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/process/ssh.hpp"

namespace musher {
namespace {

constexpr Duration kFirstBackOff = Milliseconds(250);
constexpr Duration kLongestBackOff = Milliseconds(10'000);
constexpr int kEndsWithinMS = 100;                // of ssh, after SIGKILL
constexpr std::size_t kLongestGreeting = 65'536;  // with what a login may print before it
constexpr std::size_t kMostErrors = 4'096;
constexpr std::string_view kGreeting = "musher-host ";
constexpr std::size_t kBootIdLength = 36;
// After kReadRunning: a HostId(), as base/host.cpp makes it, for how many seconds it has run, and
// the pid of what it becomes; then D-Bus.
constexpr const char* kRemoteCommand =
    "printf \"musher-host %s/%s %s %s\\n\" "
    "\"$(cat /proc/sys/kernel/random/boot_id)\" \"$(stat -Lc %i /proc/self/ns/pid)\" "
    "\"$running\" \"$$\" && exec systemd-stdio-bridge";

// As the shell of another host has it (kReadRunning): since the first process was started, which in
// a container is later than the boot.
Duration BootTimeHere() {
  constexpr std::int64_t kTicksPerSecond = 100;
  const auto first = static_cast<std::int64_t>(StartTimeOf(1).value_or(0));
  return Milliseconds(first * 1'000 / kTicksPerSecond);
}

BusMessage Own(sd_bus_message* message) {
  return {message, [](sd_bus_message* m) { sd_bus_message_unref(m); }};
}

struct Greeting {
  std::string host_id;
  Duration running{};
  pid_t bridge = 0;
};

// Reads "<boot id>/<pid namespace> <uptime in seconds> <pid>". A host that is short of memory
// prints only a part of it, and would be taken for a rebooted host.
std::optional<Greeting> ReadGreetingLine(std::string_view text) {
  const auto all = [](std::string_view part, std::string_view of) {
    return !part.empty() && part.find_first_not_of(of) == std::string_view::npos;
  };
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos || space <= kBootIdLength) return std::nullopt;
  const std::string_view id = text.substr(0, space);
  const std::size_t end = std::min(text.find(' ', space + 1), text.size());
  const std::string_view up = text.substr(space + 1, end - space - 1);
  const std::string_view pid = text.substr(std::min(end + 1, text.size()));
  pid_t bridge = 0;
  std::from_chars(pid.data(), pid.data() + pid.size(), bridge);
  const bool named = all(id.substr(0, kBootIdLength), "0123456789abcdef-") &&
                     id[kBootIdLength] == '/' && all(id.substr(kBootIdLength + 1), "0123456789");
  const std::string_view whole = up.substr(0, up.find('.'));
  std::int64_t seconds = 0;
  if (!named || !all(whole, "0123456789") ||
      std::from_chars(whole.data(), whole.data() + whole.size(), seconds).ec != std::errc() ||
      seconds > std::numeric_limits<std::int32_t>::max()) {
    return std::nullopt;
  }
  return Greeting{std::string(id), std::chrono::seconds(seconds), bridge};
}

}  // namespace

// What a callback of sd-bus gets. It outlives the slot, since it is dropped after the bus.
struct HostBus::PendingReply {
  HostBus* bus = nullptr;
  std::uint64_t call = 0;

  // Only takes the message: what follows may end the connection.
  static int Take(sd_bus_message* message, void* userdata, sd_bus_error* /*error*/) {
    const auto* self = static_cast<const PendingReply*>(userdata);
    self->bus->received_.push_back({Own(sd_bus_message_ref(message)), self->call});
    return 1;
  }
};

HostBus::HostBus(transport::EventLoop& loop, Options options, Hooks hooks)
    : loop_(loop),
      options_(std::move(options)),
      hooks_(std::move(hooks)),
      back_off_(kFirstBackOff) {}

HostBus::~HostBus() {
  Close();
}

void HostBus::Open() {
  if (state_ != State::kClosed && state_ != State::kWaiting) return;
  retry_ = loop_.At(loop_.Now(), [this] { Connect(); });
}

void HostBus::Close() {
  state_ = State::kClosed;
  retry_ = nullptr;
  DropBus();
  DropSsh();
}

// The connection may outlast a suspend of this computer, which the loop's time does not count.
Duration HostBus::running() const {
  return SinceBoot() - booted_;
}

// --- this host ---

// False: `why_` says why it is not connected. A socket of this host connects at once.
bool HostBus::ConnectHere() {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const bool fits = options_.socket.size() < sizeof(address.sun_path);
  if (fits) std::memcpy(address.sun_path, options_.socket.c_str(), options_.socket.size() + 1);
  stream_ = UniqueFd(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const bool connected =
      fits && stream_.valid() &&
      connect(stream_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  if (!connected) {
    why_ = SystemError("no connection to its D-Bus (" + options_.socket + ")").message;
    return false;
  }
  host_id_ = HostId();
  booted_ = BootTimeHere();
  return true;
}

// --- ssh ---

void HostBus::Connect() {
  retry_ = nullptr;
  greeting_.clear();
  errors_.clear();
  why_.clear();
  if (!options_.socket.empty()) {
    if (!ConnectHere()) return Ended();
    ArmConnectDeadline();
    return Subscribe();
  }
  std::array<int, 2> streams{-1, -1};
  std::array<int, 2> pipe{-1, -1};
  const bool made = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, streams.data()) == 0 &&
                    pipe2(pipe.data(), O_CLOEXEC) == 0;
  stream_ = UniqueFd(streams[0]);
  errors_pipe_ = UniqueFd(pipe[0]);
  const UniqueFd theirs(streams[1]);
  const UniqueFd their_errors(pipe[1]);
  ProgramSpec spec;
  spec.argv = options_.ssh;
  // Another shell than sh may read the line.
  const std::string end_last =
      bridge_ == 0 ? "" : EndBridge(host_id_.substr(0, kBootIdLength), bridge_);
  spec.argv.push_back("exec sh -c '" + end_last + kReadRunning + kRemoteCommand + "'");
  spec.env = {{"LC_ALL", "C"}};
  spec.without = {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID", "SSH_ASKPASS"};
  spec.input = spec.output = theirs.get();
  spec.errors = their_errors.get();
  // Ctrl-C in the terminal of the controller is not for it, and it has none to ask in.
  spec.after_fork = [](char* const*) { setsid(); };
  state_ = State::kGreeting;
  Result<ForkedProgram> ssh =
      made ? ForkProgram(spec) : Result<ForkedProgram>(SystemError("can't make a pipe"));
  auto pidfd = ssh ? OpenPidfd(ssh.value().pid()) : Result<UniqueFd>(ssh.error());
  if (!pidfd) {
    why_ = pidfd.error().message;
    return Ended();
  }
  ssh_ = std::move(ssh).value();
  pidfd_ = std::move(pidfd).value();
  fcntl(stream_.get(), F_SETFL, O_NONBLOCK);
  fcntl(errors_pipe_.get(), F_SETFL, O_NONBLOCK);
  stream_watch_ = loop_.WhenReadable(stream_.get(), [this] { ReadGreeting(); });
  errors_watch_ = loop_.WhenReadable(errors_pipe_.get(), [this] { ReadErrors(); });
  exit_watch_ = loop_.WhenReadable(pidfd_.get(), [this] { Ended(); });
  ArmConnectDeadline();
}

void HostBus::ArmConnectDeadline() {
  deadline_ = loop_.At(loop_.Now() + options_.connect_within, [this] {
    End("no answer within " + std::to_string(ToMilliseconds(options_.connect_within) / 1000) +
        " s");
  });
}

// Byte by byte: what follows the line is for sd-bus.
void HostBus::ReadGreeting() {
  char byte = 0;
  for (;;) {
    const ssize_t count = read(stream_.get(), &byte, 1);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return;
    if (count <= 0) {
      stream_watch_ = nullptr;  // ssh is about to end
      return;
    }
    greeting_.push_back(byte);
    if (greeting_.size() > kLongestGreeting) return End("its login prints without end");
    if (byte != '\n') continue;
    const std::size_t line = greeting_.rfind('\n', greeting_.size() - 2);
    const std::string text = greeting_.substr(line == std::string::npos ? 0 : line + 1);
    if (!text.starts_with(kGreeting)) continue;
    const auto greeting = ReadGreetingLine(
        std::string_view(text).substr(kGreeting.size(), text.size() - kGreeting.size() - 1));
    if (!greeting) return End("it does not say which host it is");
    if (hooks_.refuse) {
      const std::string why = hooks_.refuse(greeting->host_id, greeting->running);
      if (!why.empty()) return End(why);
    }
    host_id_ = greeting->host_id;
    bridge_ = greeting->bridge;
    booted_ = SinceBoot() - greeting->running;
    return Subscribe();
  }
}

void HostBus::ReadErrors() {
  std::array<char, 1024> buffer{};
  for (;;) {
    const ssize_t count = read(errors_pipe_.get(), buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errors_watch_ = nullptr;
    if (count <= 0) return;
    errors_.append(buffer.data(), static_cast<std::size_t>(count));
    if (errors_.size() > kMostErrors) errors_.erase(0, errors_.size() - kMostErrors);
  }
}

// Ended() follows, once ssh has ended; of this host in the next turn.
void HostBus::End(const std::string& why) {
  if (state_ == State::kEnding || state_ == State::kClosed) return;
  state_ = state_ == State::kUp ? State::kUp : State::kEnding;
  why_ = why;
  DropBus();
  stream_watch_ = nullptr;
  if (!options_.socket.empty()) retry_ = loop_.At(loop_.Now(), [this] { Ended(); });
  if (pidfd_.valid()) SendSignal(pidfd_.get(), SIGKILL);
}

void HostBus::Ended() {
  const bool was_up = state_ == State::kUp;
  if (errors_pipe_.valid()) ReadErrors();
  std::string why = why_;
  if (const auto failure = ssh_ ? ssh_->Failure(Duration::zero()) : std::nullopt) {
    why = failure->error.message;
  }
  if (why.empty()) why = LastLineOf(errors_);
  if (why.empty()) why = was_up ? "the connection has ended" : "ssh has ended";
  DropBus();
  DropSsh();
  const SshTrouble trouble = options_.socket.empty()
                                 ? SshTroubleOf(why, options_.login)
                                 : SshTrouble{why + "; see `systemctl status dbus`", false};
  trouble_ = trouble.text;
  state_ = State::kWaiting;
  if (was_up) back_off_ = kFirstBackOff;
  retry_ = loop_.At(loop_.Now() + back_off_, [this] { Connect(); });
  back_off_ = std::min(back_off_ * 2, kLongestBackOff);
  hooks_.on_down(was_up, trouble.for_good);
}

void HostBus::DropSsh() {
  stream_watch_ = nullptr;
  errors_watch_ = nullptr;
  exit_watch_ = nullptr;
  deadline_ = nullptr;
  stream_ = UniqueFd();
  errors_pipe_ = UniqueFd();
  if (pidfd_.valid()) {
    SendSignal(pidfd_.get(), SIGKILL);
    // While it waits for a disk that hangs it does not end, and the loop does not wait for it.
    pollfd ended{pidfd_.get(), POLLIN, 0};
    poll(&ended, 1, kEndsWithinMS);
    ReapEndedChild(ssh_->pid());
  }
  pidfd_ = UniqueFd();
  ssh_.reset();
}

// --- D-Bus ---

void HostBus::Subscribe() {
  state_ = State::kSubscribing;
  stream_watch_ = nullptr;
  const int fd = fcntl(stream_.get(), F_DUPFD_CLOEXEC, 0);
  stream_ = UniqueFd();
  bool made = fd >= 0 && sd_bus_new(&bus_) >= 0;
  if (!made && fd >= 0) close(fd);
  made = made && sd_bus_set_fd(bus_, fd, fd) >= 0 && sd_bus_set_bus_client(bus_, 1) >= 0 &&
         sd_bus_start(bus_) >= 0;
  for (const std::string& match : options_.matches) {
    if (!made) break;
    pending_.push_back(std::make_unique<PendingReply>(PendingReply{this, 0}));
    made = sd_bus_add_match_async(bus_, nullptr, match.c_str(), &PendingReply::Take, nullptr,
                                  pending_.back().get()) >= 0;
  }
  if (!made) return End("D-Bus could not be begun");
  stream_watch_ = loop_.WhenReadable(sd_bus_get_fd(bus_), [this] { Process(); });
  Send(NewCall("/org/freedesktop/systemd1", "org.freedesktop.systemd1.Manager", "Subscribe"),
       [this](const BusMessage& reply) {
         if (sd_bus_message_is_method_error(reply.get(), nullptr) > 0) {
           const sd_bus_error* error = sd_bus_message_get_error(reply.get());
           return End("its systemd answers: " +
                      std::string(error->message != nullptr ? error->message : error->name));
         }
         state_ = State::kUp;
         back_off_ = kFirstBackOff;
         trouble_.clear();
         deadline_ = nullptr;
         hooks_.on_up();
       });
}

BusMessage HostBus::NewCall(const std::string& path, const std::string& interface,
                            const std::string& method) {
  sd_bus_message* call = nullptr;
  const bool made = bus_ != nullptr && sd_bus_message_new_method_call(
                                           bus_, &call, "org.freedesktop.systemd1", path.c_str(),
                                           interface.c_str(), method.c_str()) >= 0;
  return made ? Own(call) : nullptr;
}

void HostBus::Send(const BusMessage& call, OnReply done) {
  if (!call || bus_ == nullptr) return;
  const std::uint64_t id = next_call_++;
  pending_.push_back(std::make_unique<PendingReply>(PendingReply{this, id}));
  if (sd_bus_call_async(bus_, nullptr, call.get(), &PendingReply::Take, pending_.back().get(), 0) <
      0) {
    pending_.pop_back();
    return;  // the connection has ended, which is reported
  }
  calls_[id] = std::move(done);
  ArmTimer();
}

void HostBus::Process() {
  int more = 1;
  while (bus_ != nullptr && more > 0) more = sd_bus_process(bus_, nullptr);
  const bool over = more < 0 || (bus_ != nullptr && sd_bus_is_open(bus_) <= 0);
  if (!over) {
    Handle(std::exchange(received_, {}));
    if (bus_ != nullptr) ArmTimer();
    return;
  }
  // sd-bus has answered all calls with errors of its own, which say nothing of systemd. ssh says
  // why within a moment, if it is what has ended.
  stream_watch_ = nullptr;
  DropBus();
  const Duration wait = options_.socket.empty() ? Milliseconds(500) : Duration{};
  deadline_ = loop_.At(loop_.Now() + wait, [this] { End("its D-Bus has ended"); });
}

void HostBus::Handle(const std::vector<Received>& received) {
  const std::weak_ptr<bool> alive = alive_;
  for (const Received& one : received) {
    if (alive.expired() || bus_ == nullptr) return;
    if (one.call == 0) {
      if (state_ == State::kUp) hooks_.on_signal(one.message);
      continue;
    }
    std::erase_if(pending_, [&](const auto& pending) { return pending->call == one.call; });
    const auto call = calls_.extract(one.call);
    if (!call.empty() && call.mapped()) call.mapped()(one.message);
  }
}

// What sd-bus waits for beside its input: a reply in time, and room to write.
void HostBus::ArmTimer() {
  constexpr Duration kWriteAgain = Milliseconds(5);
  std::uint64_t due_us = 0;
  const bool has_due = sd_bus_get_timeout(bus_, &due_us) >= 0 && due_us != UINT64_MAX;
  const bool writes = (sd_bus_get_events(bus_) & POLLOUT) != 0;
  bus_timer_ = nullptr;
  if (!has_due && !writes) return;
  const Time due = has_due ? Time(std::chrono::microseconds(due_us)) : loop_.Now() + kWriteAgain;
  const Time at = writes ? std::min(due, loop_.Now() + kWriteAgain) : due;
  bus_timer_ = loop_.At(at, [this] { Process(); });
}

void HostBus::DropBus() {
  bus_timer_ = nullptr;
  if (bus_ != nullptr) {
    stream_watch_ = nullptr;  // before its descriptor
    sd_bus_close(bus_);
    sd_bus_unref(bus_);
    bus_ = nullptr;
  }
  received_.clear();
  calls_.clear();
  pending_.clear();
}

}  // namespace musher
