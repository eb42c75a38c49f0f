#include "musher/transport/linux_event_loop.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/host.hpp"

namespace musher::transport {

namespace {

// Keys of the epoll set; watches are numbered from kFirstWatch.
constexpr std::uint64_t kWakeKey = 0;
constexpr std::uint64_t kTimerKey = 1;
constexpr std::uint64_t kFirstWatch = 2;

int Check(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

void AddToEpoll(int epoll, int fd, std::uint32_t events, std::uint64_t key) {
  epoll_event event{};
  event.events = events;
  event.data.u64 = key;
  Check(epoll_ctl(epoll, EPOLL_CTL_ADD, fd, &event), "epoll_ctl");
}

}  // namespace

class LinuxEventLoop::WatchHandle : public LoopHandle {
 public:
  WatchHandle(LinuxEventLoop& loop, std::uint64_t key) : loop_(loop), key_(key) {}
  WatchHandle(const WatchHandle&) = delete;
  WatchHandle& operator=(const WatchHandle&) = delete;
  ~WatchHandle() override {
    loop_.CheckThread();
    const auto watch = loop_.watches_.find(key_);
    epoll_ctl(loop_.epoll_.get(), EPOLL_CTL_DEL, watch->second->fd, nullptr);
    loop_.watches_.erase(watch);
  }

 private:
  LinuxEventLoop& loop_;
  std::uint64_t key_;
};

LinuxEventLoop::LinuxEventLoop()
    : epoll_(Check(epoll_create1(EPOLL_CLOEXEC), "epoll_create1")),
      wake_(Check(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), "eventfd")),
      timer_(Check(timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK), "timerfd_create")),
      next_watch_(kFirstWatch) {
  // Edge-triggered: each wake-up and each expiry counts once and need not be read back.
  AddToEpoll(epoll_.get(), wake_.get(), EPOLLIN | EPOLLET, kWakeKey);
  AddToEpoll(epoll_.get(), timer_.get(), EPOLLIN | EPOLLET, kTimerKey);
}

Duration LinuxEventLoop::TimeSuspended() const {
  return TimeSuspendedHere();
}

// Wakes the loop without holding the lock, which the loop takes at once.
void LinuxEventLoop::Post(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    posted_.push_back(std::move(work));
    if (!std::exchange(asleep_, false)) return;
  }
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(wake_.get(), &one, sizeof(one));
}

LoopHandlePtr LinuxEventLoop::At(Time when, std::function<void()> callback) {
  CheckThread();
  return timers_.Add(when, Duration::zero(), std::move(callback));
}

LoopHandlePtr LinuxEventLoop::Every(Duration period, std::function<void()> callback) {
  CheckThread();
  MUSHER_CHECK(period > Duration::zero(), "ns:", period.count());
  return timers_.Add(Now() + period, period, std::move(callback));
}

LoopHandlePtr LinuxEventLoop::WhenReadable(int fd, std::function<void()> callback) {
  CheckThread();
  const std::uint64_t key = next_watch_++;
  AddToEpoll(epoll_.get(), fd, EPOLLIN, key);
  watches_.emplace(key, std::make_shared<Watch>(Watch{fd, std::move(callback)}));
  return std::make_unique<WatchHandle>(*this, key);
}

void LinuxEventLoop::Run() {
  CheckThread();
  const RunScope running(*this);
  const Done stopped = [this] { return stop_.exchange(false); };
  if (stopped()) return;
  while (!Turn(stopped)) {
  }
}

bool LinuxEventLoop::RunUntil(const std::function<bool()>& done, Time deadline) {
  CheckThread();
  const RunScope running(*this);
  if (done()) return true;
  const LoopHandlePtr alarm = At(deadline, [] {});
  while (!Turn(done)) {
    if (Now() >= deadline) return false;
  }
  return true;
}

void LinuxEventLoop::Stop() {
  stop_ = true;
  Post([] {});  // so that Run() checks stop_
}

bool LinuxEventLoop::Turn(const Done& done) {
  ready_count_ = Poll();
  return RunDueTimers(done) || RunPosted(done) || RunReadable(done);
}

bool LinuxEventLoop::RunDueTimers(const Done& done) {
  if (!timers_.NextDue()) return false;
  const Time now = Now();
  while (timers_.RunNext(now)) {
    if (done()) return true;
  }
  return false;
}

bool LinuxEventLoop::RunPosted(const Done& done) {
  if (batch_.empty()) {
    const std::lock_guard lock(mutex_);
    batch_.swap(posted_);
  }
  while (!batch_.empty()) {
    const auto work = std::move(batch_.front());
    batch_.pop_front();
    work();
    if (done()) return true;
  }
  return false;
}

bool LinuxEventLoop::RunReadable(const Done& done) {
  for (int i = 0; i < ready_count_; ++i) {
    const auto found = watches_.find(ready_[i]);
    if (found == watches_.end()) continue;  // dropped by a callback before it
    const std::shared_ptr<Watch> watch = found->second;
    watch->callback();
    if (done()) return true;  // epoll reports the rest again
  }
  return false;
}

// Fills `ready_` and returns how many there are.
int LinuxEventLoop::Poll() {
  const bool block = MayBlock();
  if (block) ArmTimer(timers_.NextDue());
  std::array<epoll_event, kMaxReady> events{};
  const int count = epoll_wait(epoll_.get(), events.data(), kMaxReady, block ? -1 : 0);
  MUSHER_CHECK(count >= 0 || errno == EINTR, "epoll_wait, errno", errno);
  {
    const std::lock_guard lock(mutex_);
    asleep_ = false;
  }
  int ready = 0;
  for (int i = 0; i < count; ++i) {
    if (events[i].data.u64 >= kFirstWatch) ready_[ready++] = events[i].data.u64;
    if (events[i].data.u64 == kTimerKey) armed_for_.reset();
  }
  return ready;
}

// Whether no work is due. From then on Post() wakes the loop.
bool LinuxEventLoop::MayBlock() {
  const auto due = timers_.NextDue();
  const bool timer_waits = due && *due <= Now();
  const std::lock_guard lock(mutex_);
  asleep_ = !timer_waits && batch_.empty() && posted_.empty();
  return asleep_;
}

void LinuxEventLoop::ArmTimer(std::optional<Time> when) {
  if (when == armed_for_) return;
  armed_for_ = when;
  itimerspec spec{};  // all zero: disarmed
  if (when) {
    const auto since_boot = std::chrono::duration_cast<Duration>(when->time_since_epoch());
    const auto seconds = std::chrono::floor<std::chrono::seconds>(since_boot);
    spec.it_value.tv_sec = seconds.count();
    spec.it_value.tv_nsec = (since_boot - seconds).count();
  }
  timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &spec, nullptr);
}

}  // namespace musher::transport
