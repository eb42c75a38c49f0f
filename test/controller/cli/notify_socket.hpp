#pragma once
// A service manager that only listens: a socket in NOTIFY_SOCKET, as systemd gives one to a service
// of Type=notify.

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "musher/transport/unique_fd.hpp"

namespace musher {

class NotifySocket {
 public:
  // `path`: in a folder of the test's own.
  explicit NotifySocket(const std::string& path)
      : socket_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::runtime_error("cannot bind " + path);
    }
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  ~NotifySocket() {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
  }

  // What has come since the last call, each message a string.
  std::vector<std::string> Take() {
    std::vector<std::string> messages;
    std::array<char, 4096> buffer{};
    for (ssize_t size = 0; (size = recv(socket_.get(), buffer.data(), buffer.size(), 0)) >= 0;) {
      messages.emplace_back(buffer.data(), size);
    }
    return messages;
  }

  // Waits for a message that has `line` as one of its lines, half a minute at most; what comes
  // before it is dropped.
  bool WaitFor(const std::string& line) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (std::chrono::steady_clock::now() < deadline) {
      pollfd readable{socket_.get(), POLLIN, 0};
      poll(&readable, 1, 1000);
      std::array<char, 4096> buffer{};
      const ssize_t size = recv(socket_.get(), buffer.data(), buffer.size(), 0);
      if (size < 0) continue;
      const std::string message = "\n" + std::string(buffer.data(), size) + "\n";
      if (message.find("\n" + line + "\n") != std::string::npos) return true;
    }
    return false;
  }

 private:
  transport::UniqueFd socket_;
};

}  // namespace musher
