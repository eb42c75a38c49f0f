#include "musher/cli/start/progress.hpp"

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace musher::cli {
namespace {

constexpr std::size_t kLargestMessage = 128 * 1024;  // bytes
constexpr std::size_t kMostLinesWaiting = 10'000;
constexpr Duration kRetryPeriod = Milliseconds(100);

}  // namespace

std::pair<UniqueFd, UniqueFd> MakeProgressPair() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "socketpair");
  }
  return {UniqueFd(ends[0]), UniqueFd(ends[1])};
}

void ProgressSender::Send(const Progress& progress) {
  if (launcher_exited_) return;
  msg::Bytes bytes = msg::Encode(progress);
  if (bytes.size() > kLargestMessage) return;
  // A launcher that reads nothing for long loses the oldest lines, never the newest.
  if (waiting_.size() == kMostLinesWaiting) waiting_.pop_front();
  waiting_.push_back(std::move(bytes));
  Flush();
}

void ProgressSender::Send(const msg::MachineStatus& machine) {
  if (launcher_exited_ || machine == machine_) return;
  machine_ = machine;
  Progress progress;
  progress.kind = Progress::kMachine;
  progress.machine = machine;
  unsent_ = msg::Encode(progress);
  if (unsent_->size() > kLargestMessage) unsent_.reset();
  Flush();
}

void ProgressSender::Flush() {
  while (!waiting_.empty()) {
    if (!SendNow(waiting_.front())) return;
    waiting_.pop_front();
  }
  if (unsent_ && SendNow(*unsent_)) unsent_.reset();
}

// Returns whether it was sent. If the socket is full, Flush() runs again.
bool ProgressSender::SendNow(const msg::Bytes& bytes) {
  ssize_t sent = 0;
  do {
    sent = send(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  if (sent >= 0) return true;
  if (errno == EAGAIN || errno == ENOBUFS) {
    retry_ = loop_.At(loop_.Now() + kRetryPeriod, [this] { Flush(); });
  } else {
    launcher_exited_ = true;
    waiting_.clear();
    unsent_.reset();
  }
  return false;
}

ProgressReceiver::ProgressReceiver(transport::EventLoop& loop, UniqueFd socket,
                                   std::function<void(const Progress&)> on_progress,
                                   std::function<void()> on_end)
    : socket_(std::move(socket)),
      on_progress_(std::move(on_progress)),
      on_end_(std::move(on_end)),
      watch_(loop.WhenReadable(socket_.get(), [this] { Receive(); })) {}

void ProgressReceiver::Receive() {
  msg::Bytes bytes(kLargestMessage);
  const ssize_t size = recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) {
    watch_ = nullptr;
    on_end_();
    return;
  }
  bytes.resize(size);
  if (const auto progress = msg::Decode<Progress>(bytes)) on_progress_(*progress);
}

}  // namespace musher::cli
