#pragma once
// A service manager that only listens: a socket in NOTIFY_SOCKET, as systemd gives one to a service
// of Type=notify.

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdlib>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "musher/base/unique_fd.hpp"

namespace musher {

// Only Take() reads it: it gets full, and then accepts no more.
class NotifySocket {
 public:
  // `path`: in a folder of the test's own, or an abstract one that begins with '@'.
  explicit NotifySocket(const std::string& path)
      : socket_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    if (path[0] == '@') address.sun_path[0] = '\0';
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
    if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0) {
      throw std::runtime_error("cannot bind " + path);
    }
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  ~NotifySocket() {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
  }

  int fd() const { return socket_.get(); }

  // What has come since the last call, each message a string.
  std::vector<std::string> Take() {
    std::vector<std::string> messages;
    std::array<char, 4096> buffer{};
    for (ssize_t size = 0; (size = recv(socket_.get(), buffer.data(), buffer.size(), 0)) >= 0;) {
      messages.emplace_back(buffer.data(), size);
    }
    return messages;
  }

 private:
  UniqueFd socket_;
};

// The same, read all the time by a thread of its own.
class ServiceManagerThatReads {
 public:
  explicit ServiceManagerThatReads(const std::string& path) : socket_(path) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    end_ = UniqueFd(ends[0]);
    running_ = UniqueFd(ends[1]);
    reader_ = std::jthread([this] { Read(); });
  }
  ~ServiceManagerThatReads() { running_ = {}; }

  // What has come since the last call, each message a string.
  std::vector<std::string> Take() {
    const std::lock_guard lock(mutex_);
    Drain();
    return std::exchange(messages_, {});
  }

  // Waits for a message that has `line` as one of its lines, a minute at most; what comes before it
  // is dropped.
  bool WaitFor(const std::string& line) {
    std::unique_lock lock(mutex_);
    return come_.wait_for(lock, std::chrono::minutes(1), [&] {
      while (!messages_.empty()) {
        const std::string message = "\n" + messages_.front() + "\n";
        messages_.erase(messages_.begin());
        if (message.find("\n" + line + "\n") != std::string::npos) return true;
      }
      return false;
    });
  }

 private:
  void Read() {
    for (;;) {
      std::array<pollfd, 2> waited{{{socket_.fd(), POLLIN, 0}, {end_.get(), POLLIN, 0}}};
      poll(waited.data(), waited.size(), -1);
      if (waited[1].revents != 0) return;
      const std::lock_guard lock(mutex_);
      Drain();
      come_.notify_all();
    }
  }
  void Drain() {
    for (std::string& message : socket_.Take()) messages_.push_back(std::move(message));
  }

  NotifySocket socket_;
  UniqueFd end_;  // of this pipe: the other one is closed
  UniqueFd running_;
  std::mutex mutex_;  // guards the messages and reading
  std::condition_variable come_;
  std::vector<std::string> messages_;
  std::jthread reader_;
};

}  // namespace musher
