#pragma once
// Passes what the loop receives to a Python thread, so that the loop never waits for the GIL.
//
// Threads: Push…() and Close() from any; Pop() from any, without the GIL.

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/messages/cdr.hpp"

namespace musher::python {

// A suspension of the computer counts.
inline Duration SinceBoot() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

struct Item {
  std::int64_t key = 0;  // of whom it is for, chosen by the Python layer
  int kind = 0;          // chosen by the endpoint
  std::int32_t code = 0;
  std::string text;
  std::uint64_t token = 0;
  msg::Bytes bytes;
  Duration received{};  // by the mailbox, since the boot
  // For so long this process could not run just before that, if so: the item may be as old.
  std::optional<Duration> after_break;

  // For its Python thread.
  Duration Waited() const { return SinceBoot() - received; }
};

class Mailbox {
 public:
  // Throws std::system_error without a file descriptor: Pop() would wait for ever.
  Mailbox() : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (!fd_.valid()) {
      throw std::system_error(errno, std::generic_category(),
                              "no file descriptor for what is received");
    }
  }

  // Beyond `limit` items of this key (0: none) the oldest one is dropped and counted.
  void Push(Item item, std::size_t limit = 0) {
    const std::lock_guard lock(mutex_);
    if (limit > 0) Limit(item.key, limit);
    item.received = SinceBoot();
    items_.push_back(std::move(item));
    Wake();
  }
  // Takes the place of a waiting item of this key, if there is one, and has waited for as long.
  void PushLatest(Item item) {
    const std::lock_guard lock(mutex_);
    for (Item& waiting : items_) {
      if (waiting.key != item.key) continue;
      item.received = waiting.received;
      waiting = std::move(item);
      return;
    }
    item.received = SinceBoot();
    items_.push_back(std::move(item));
    Wake();
  }
  // Before all others.
  void PushFirst(Item item) {
    const std::lock_guard lock(mutex_);
    item.received = SinceBoot();
    items_.push_front(std::move(item));
    Wake();
  }
  // A fork shares the descriptor, and would wake, or be woken by, the process that has made it.
  bool InThisProcess() const { return getpid() == process; }
  const pid_t process = getpid();

  // Does nothing in a fork.
  void Close() {
    if (!InThisProcess()) return;
    const std::lock_guard lock(mutex_);
    closed_ = true;
    Wake();
  }
  bool closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }
  std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

  enum class Wait { kItem, kClosed, kTimeout, kSignal };
  // Waits at most `timeout_ms` (-1: without a limit), or for a signal of this thread.
  Wait Pop(Item& item, int timeout_ms) {
    pollfd wait{fd_.get(), POLLIN, 0};
    const int ready = poll(&wait, 1, timeout_ms);
    if (ready < 0) return Wait::kSignal;
    const std::lock_guard lock(mutex_);
    if (items_.empty()) return closed_ ? Wait::kClosed : Wait::kTimeout;
    item = std::move(items_.front());
    items_.pop_front();
    if (items_.empty() && !closed_) {
      std::uint64_t count = 0;
      static_cast<void>(read(fd_.get(), &count, sizeof count));
    }
    return Wait::kItem;
  }

 private:
  void Wake() {
    const std::uint64_t one = 1;
    static_cast<void>(write(fd_.get(), &one, sizeof one));
  }
  void Limit(std::int64_t key, std::size_t limit) {
    std::size_t count = 0;
    for (const Item& item : items_) count += item.key == key ? 1 : 0;
    for (auto i = items_.begin(); count >= limit && i != items_.end();) {
      if (i->key != key) {
        ++i;
        continue;
      }
      i = items_.erase(i);
      --count;
      ++dropped_;
    }
  }

  const UniqueFd fd_;
  mutable std::mutex mutex_;  // guards the members below
  std::deque<Item> items_;
  bool closed_ = false;
  std::uint64_t dropped_ = 0;
};

}  // namespace musher::python
