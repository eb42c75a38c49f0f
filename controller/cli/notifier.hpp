#pragma once
// Messages to a service manager (sd_notify(3)), sent without ever waiting for it: PID 1 may be slow
// or stand still, and its socket takes only so many messages that nobody has read. (libsystemd's
// sd_notify() waits for room, and the loop with it.)
//
// A message that finds no room is kept, the latest of each kind, and sent when there is. Those that
// are kept stay in order, and none overtakes them.
//
// Threads: loop thread only.

#include <sys/socket.h>
#include <sys/un.h>

#include <string>
#include <vector>

#include "musher/transport/event_loop.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher::cli {

class Notifier {
 public:
  // To the socket that NOTIFY_SOCKET names, an abstract one if it begins with '@'. Without it, or
  // if it names none, nothing is done at all. The loop must outlive it.
  explicit Notifier(transport::EventLoop& loop);
  Notifier(const Notifier&) = delete;
  Notifier& operator=(const Notifier&) = delete;
  // Tries once more what is kept.
  ~Notifier();

  bool enabled() const { return socket_.valid(); }

  // "READY=1", say; its kind is what is before the first '='.
  void Tell(const std::string& message);
  // "WATCHDOG=1", which is dropped where it finds no room.
  void Ping();

 private:
  bool Send(const std::string& message);
  void SendKept();

  transport::EventLoop& loop_;
  transport::UniqueFd socket_;
  sockaddr_un address_{};
  socklen_t address_size_ = 0;
  std::vector<std::string> kept_;
  transport::LoopHandlePtr again_;
};

}  // namespace musher::cli
