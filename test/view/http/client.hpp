#pragma once
// A client that sends and receives raw bytes, and a server on a loop of its own beside it. Every
// wait has a deadline.

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <future>
#include <string>
#include <string_view>
#include <thread>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/view/http/server.hpp"

namespace musher::http {

inline constexpr Duration kTestTimeout = std::chrono::seconds(60);

class Client {
 public:
  // `receive_buffer`: of the kernel, in bytes; 0: its default.
  explicit Client(std::uint16_t port, int receive_buffer = 0)
      : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (receive_buffer > 0) {
      setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }

  bool connected() const { return connected_; }
  int fd() const { return socket_.get(); }

  // Whether all was sent: false once the server has closed the connection.
  bool Send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = send(fd(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

  // Receives more; false at the end of the connection or after kTestTimeout.
  bool Receive(Duration timeout = kTestTimeout) {
    pollfd poll_fd{fd(), POLLIN, 0};
    if (poll(&poll_fd, 1, static_cast<int>(ToMilliseconds(timeout))) <= 0) return false;
    std::string chunk(65536, '\0');
    const ssize_t size = recv(fd(), chunk.data(), chunk.size(), 0);
    if (size <= 0) return ended_ = true, false;
    received_.append(chunk, 0, static_cast<std::size_t>(size));
    return true;
  }

  // Exactly `size` bytes; fewer at the end.
  std::string Take(std::size_t size) {
    while (received_.size() < size && Receive()) {
    }
    std::string taken = received_.substr(0, size);
    received_.erase(0, size);
    return taken;
  }

  struct Reply {
    unsigned status = 0;  // 0: none
    std::string head;
    std::string body;
  };
  // The next response. `head_only`: it has a Content-Length without a body.
  Reply TakeReply(bool head_only = false) {
    Reply reply;
    std::size_t end = 0;
    while ((end = received_.find("\r\n\r\n")) == std::string::npos) {
      if (!Receive()) return reply;
    }
    reply.head = Take(end + 4);
    reply.status = static_cast<unsigned>(std::stoul(reply.head.substr(9, 3)));
    const std::string_view name = "Content-Length: ";
    const std::size_t at = reply.head.find(name);
    if (at != std::string::npos && !head_only) {
      reply.body = Take(std::stoul(reply.head.substr(at + name.size())));
    }
    return reply;
  }
  Reply Get(std::string_view target, std::string_view headers = {}) {
    Send("GET " + std::string(target) + " HTTP/1.1\r\nHost: localhost\r\n" + std::string(headers) +
         "\r\n");
    return TakeReply();
  }

  // Whether the server ends the connection in time.
  bool Ends() {
    while (Receive()) {
    }
    return ended_;
  }
  const std::string& received() const { return received_; }

 private:
  UniqueFd socket_;
  bool connected_ = false;
  bool ended_ = false;
  std::string received_;
};

// A server whose loop has a thread of its own. Its functions run there.
class RunningServer {
 public:
  RunningServer(Options options, const OnRequest& on_request, const OnWebSocket& on_websocket) {
    options.port = 0;
    auto made = Server::Make(loop_, options, on_request, on_websocket);
    server_ = std::move(made).value();
    port_ = server_->port();
    thread_ = std::thread([this] { loop_.Run(); });
  }
  ~RunningServer() {
    Stop();
    loop_.Stop();
    thread_.join();
  }
  RunningServer(const RunningServer&) = delete;
  RunningServer& operator=(const RunningServer&) = delete;

  // Destroys the server on its loop; returns how long that took.
  Duration Stop() {
    std::promise<Duration> done;
    loop_.Post([&] {
      const Time begin = loop_.Now();
      server_.reset();
      done.set_value(loop_.Now() - begin);
    });
    return done.get_future().get();
  }
  std::uint16_t port() const { return port_; }
  transport::EventLoop& loop() { return loop_; }

 private:
  transport::LinuxEventLoop loop_;
  std::unique_ptr<Server> server_;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

inline std::shared_ptr<const std::string> Shared(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

// Answers "GET /path body=..." to all.
inline void Echo(const Request& request, const Respond& respond) {
  Response response;
  response.content_type = "text/plain";
  response.body = Shared(request.method + " " + request.path + " body=" + request.body);
  respond(response);
}

// Refuses all.
inline WebSocketHandlers NoWebSocket(const std::shared_ptr<WebSocket>& socket) {
  socket->Close(1008, "no WebSocket here");
  return {};
}

}  // namespace musher::http
