#pragma once
// What the connections of one server share. Threads: the network's, unless something else is said.

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "musher/view/http/access.hpp"
#include "musher/view/http/server.hpp"

namespace boost::asio {
class io_context;
}

namespace musher::http {

// What the loop has of an open WebSocket.
class Endpoint {
 public:
  virtual ~Endpoint() = default;
  virtual void Release() = 0;  // drops the owner's functions
};

// The owner's functions. Runs work on the loop for as long as the server exists.
class Dispatch {
 public:
  Dispatch(transport::EventLoop& loop, OnRequest on_request, OnWebSocket on_websocket)
      : on_request(std::move(on_request)), on_websocket(std::move(on_websocket)), loop_(loop) {}

  const OnRequest on_request;      // loop
  const OnWebSocket on_websocket;  // loop

  // Network thread only. `work` is dropped, on the loop, once the server is destroyed.
  static void Post(const std::shared_ptr<Dispatch>& self, std::function<void()> work);

  // Loop thread only: the functions of `endpoint` are kept until it is removed or all is stopped.
  void Add(std::shared_ptr<Endpoint> endpoint) { endpoints_.insert(std::move(endpoint)); }
  void Remove(const std::shared_ptr<Endpoint>& endpoint) { endpoints_.erase(endpoint); }
  void Stop();

 private:
  transport::EventLoop& loop_;
  bool alive_ = true;                              // loop
  std::set<std::shared_ptr<Endpoint>> endpoints_;  // loop
};

// Runs work on the network thread until the server is destroyed; then drops it. Any thread.
class Mailbox {
 public:
  explicit Mailbox(boost::asio::io_context& network) : network_(&network) {}
  void Post(std::function<void()> work);
  void Close();

 private:
  std::mutex mutex_;
  boost::asio::io_context* network_;  // null: closed
};

// A connection.
class Session {
 public:
  enum class Phase {
    kSilent,   // it has not sent a complete request
    kIdle,     // between requests
    kBusy,     // a request is handled, or a WebSocket is open
    kClosing,  // it ends within a second
  };

  virtual ~Session() = default;
  virtual Phase phase() const = 0;
  virtual Time since() const = 0;  // when it last received something
  virtual void Shutdown() = 0;     // ends it in an orderly way, soon
  virtual void Abort() = 0;        // ends it now
};

struct Network {
  boost::asio::io_context& io;
  const Options options;
  const HostNames names;
  const std::shared_ptr<Dispatch> dispatch;
  const std::shared_ptr<Mailbox> mailbox;
  std::set<std::shared_ptr<Session>> sessions;
  bool ending = false;

  void Add(std::shared_ptr<Session> session);
  // The session is destroyed once its last operation has ended.
  void Remove(const std::shared_ptr<Session>& session);
};

// How long a connection that ends may take for its last bytes.
inline constexpr Duration kCloseTimeout = std::chrono::seconds(1);

// Begins with a connected socket. `refuse`: answers 503 and ends.
void StartHttpSession(Network& network, int socket, bool refuse);

// Takes over a socket whose request for a WebSocket has been checked.
struct Upgrade {
  int socket = -1;
  bool six = false;  // the socket's family is IPv6
  std::string key;   // Sec-WebSocket-Key
  std::string subprotocol;
  Request request;
};
void StartWebSocketSession(Network& network, Upgrade upgrade);

}  // namespace musher::http
