#pragma once
// Messages to a service manager (sd_notify(3)), sent without blocking: PID 1 may be slow or
// stopped, and its socket queues only a limited number of unread messages. (libsystemd's
// sd_notify() waits for room and would block the loop.)
//
// A message that finds no room is queued, only the latest of each kind, and sent later. Queued
// messages keep their order, and no other message overtakes them.
//
// Threads: loop thread only.

#include <sys/socket.h>
#include <sys/un.h>

#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

class ServiceNotifier {
 public:
  // Sends to the socket that NOTIFY_SOCKET names, an abstract one if it begins with '@'. Without a
  // valid NOTIFY_SOCKET it does nothing. The loop must outlive it.
  explicit ServiceNotifier(transport::EventLoop& loop);
  ServiceNotifier(const ServiceNotifier&) = delete;
  ServiceNotifier& operator=(const ServiceNotifier&) = delete;
  // Tries the queued messages once more.
  ~ServiceNotifier();

  bool enabled() const { return socket_.valid(); }

  // Sends for example "READY=1"; the kind of a message is the part before the first '='.
  void Notify(const std::string& message);
  // Sends "WATCHDOG=1"; drops it if there is no room.
  void Ping();

 private:
  bool Send(const std::string& message);
  void SendQueued();

  transport::EventLoop& loop_;
  UniqueFd socket_;
  sockaddr_un address_{};
  socklen_t address_size_ = 0;
  std::vector<std::string> queued_;
  transport::LoopHandlePtr retry_;
};

}  // namespace musher::cli
