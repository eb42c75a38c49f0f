#pragma once
// The HTTP/1.1 and WebSocket server of a page. It knows no robot: requests and messages go to the
// owner's functions, answers come back from them.
//
//   http::Options options;
//   options.subprotocols = {"musher.view.v1"};
//   auto server = http::Server::Make(loop, options, on_request, on_websocket);
//
// What the server refuses itself, with the JSON of ErrorResponse(): a malformed request or path
// (400), a Host that is not this host or an Origin that is not this page (403), a method other than
// GET, HEAD and POST (405), a request that is not complete in time (408), a body, path or header
// that is too large (413, 414, 431), a connection too many (503). 404 is the owner's answer.
//
// A page of another site can make the browser of an operator send requests to this server, and a
// name that its owner points to 127.0.0.1 makes that page "same-origin". So a request must name
// this host: localhost, an address of this host, its hostname (also with ".local") or one of
// Options::hosts. A POST with an Origin must come from the very page that this server serves, or
// from one of Options::hosts; a WebSocket also from a page on another port of this host. Without
// Origin both are permitted only to programs that are not browsers.
//
// Threads: the server has one of its own, for the network. All functions of the owner run on the
// loop, and all functions here are called there. A client that does not read fills its own bounded
// queue and is closed; it delays no other. The destructor ends all connections within a second;
// from then on no function of the owner is called, also not on_closed. A WebSocket or Respond
// that the owner still has does nothing then.
//
// Errors: Make() fails if the address is invalid or in use. Times are durations of the steady
// clock.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::http {

struct Request {
  std::string method;  // "GET" (also of HEAD: the server leaves the body out) or "POST"
  std::string path;    // decoded, valid UTF-8, begins with '/', has no "." or ".." as a part
  std::map<std::string, std::string> query;  // decoded; the first of a name counts
  std::string body;                          // of a POST
  std::string peer;    // the client: "192.168.1.7", "::1", "10.1.2.3 through a proxy" of this host
  bool local = false;  // from this host, and not through a proxy
  std::map<std::string, std::string> headers;  // names in lower case
  std::map<std::string, std::string> cookies;
};

struct Response {
  unsigned status = 200;
  std::string content_type = "application/json";
  std::shared_ptr<const std::string> body;  // null: empty
  std::vector<std::pair<std::string, std::string>> headers;
};

// {"error":{"code":110,"message":"..."}}
Response ErrorResponse(unsigned status, std::int32_t code, std::string_view message);

// Answers the request, once; a second call does nothing. The server answers 500 once the last copy
// is dropped without a call.
using Respond = std::function<void(Response)>;

// An open WebSocket. The owner shares it with the server; after the end it does nothing.
class WebSocket {
 public:
  virtual ~WebSocket() = default;

  // Appends a message to the queue. A client whose queue exceeds Options::max_queue is closed with
  // code 1013.
  virtual void Send(std::shared_ptr<const std::string> message, bool binary) = 0;
  // The bytes that the kernel has not taken yet.
  virtual std::size_t queued_bytes() const = 0;
  // Sends a ping, past the queue, unless one is being sent. `payload`: at most 125 bytes, different
  // for each ping of the connection.
  virtual void Ping(std::string payload) = 0;
  // Sends what is queued, then the close frame; the connection ends at the latest a second later.
  // on_message is not called after it.
  virtual void Close(unsigned code, std::string reason) = 0;
  virtual const Request& request() const = 0;          // that opened it
  virtual const std::string& subprotocol() const = 0;  // empty: the client requested none
};

struct WebSocketHandlers {
  std::function<void(std::string message, bool binary)> on_message;
  std::function<void()> on_drained;  // the queue is empty again
  // The client has answered that ping, before all messages that follow. Not called for each one: a
  // client may answer only the last of several.
  std::function<void(const std::string& payload)> on_pong = {};
  std::function<void()> on_closed;  // once, the last call; not after the server is destroyed
};

using OnRequest = std::function<void(Request, Respond)>;
// Called when a WebSocket is open. To refuse it (its path, its session): Close(1008, "reason").
// Handlers may be empty.
using OnWebSocket = std::function<WebSocketHandlers(std::shared_ptr<WebSocket>)>;

struct Options {
  std::string bind = "127.0.0.1";     // an address; "0.0.0.0" or "::" for all of this host
  std::uint16_t port = 8765;          // 0: any
  std::size_t max_connections = 256;  // when full, one that never sent a request makes room
  std::size_t max_body = 1 << 20;     // bytes
  std::size_t max_message = 4 << 20;  // bytes of a WebSocket message from a client
  std::size_t max_queue = 8 << 20;    // bytes; a client with more is closed
  Duration header_timeout = std::chrono::seconds(5);  // from its first byte to its last
  // Limit for a connection between requests, a body, a write, and a WebSocket that answers no
  // ping.
  Duration idle_timeout = std::chrono::seconds(60);
  std::vector<std::string> subprotocols;  // by preference
  // Further names accepted in Host and Origin. An entry with "://" is compared with the whole
  // Origin: "https://app.foxglove.dev", "file://".
  std::vector<std::string> hosts;
};

class Server {
 public:
  static Result<std::unique_ptr<Server>> Make(transport::EventLoop& loop, const Options& options,
                                              OnRequest on_request, OnWebSocket on_websocket);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;

 private:
  class Impl;
  explicit Server(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace musher::http
