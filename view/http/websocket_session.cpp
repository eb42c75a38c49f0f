#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <deque>
#include <iterator>
#include <utility>

#include "musher/view/http/session.hpp"

namespace musher::http {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using ErrorCode = boost::system::error_code;

constexpr int kMostUnsent = 65'536;  // bytes

// A message in the queue costs some memory beside its bytes.
constexpr std::size_t kMessageCost = 64;
// Messages that the loop has not handled yet, in parts of a whole window; a large one counts more.
constexpr std::size_t kWindow = 64;
constexpr std::size_t kMostPings = 64;  // without an answer

class WebSocketSession;

// What the loop has of a WebSocket.
class Handle final : public WebSocket, public Endpoint {
 public:
  Handle(std::weak_ptr<WebSocketSession> session, const Network& network, Request request,
         std::string subprotocol)
      : session_(std::move(session)),
        mailbox_(network.mailbox),
        max_queue_(network.options.max_queue),
        request_(std::move(request)),
        subprotocol_(std::move(subprotocol)) {}

  void Send(std::shared_ptr<const std::string> message, bool binary) override;
  std::size_t queued_bytes() const override { return bytes_; }
  void Ping(std::string payload) override;
  void Close(unsigned code, std::string reason) override;
  const Request& request() const override { return request_; }
  const std::string& subprotocol() const override { return subprotocol_; }

  void SetHandlers(WebSocketHandlers handlers) { handlers_ = std::move(handlers); }
  void OnMessage(std::string message, bool binary, std::size_t weight);
  void OnPong(const std::string& payload) const {
    if (!closing_ && handlers_.on_pong) handlers_.on_pong(payload);
  }
  void OnDrained() const {
    if (!closing_ && handlers_.on_drained) handlers_.on_drained();
  }
  void OnClosed();
  void Release() override {
    closing_ = true;
    const WebSocketHandlers dropped = std::exchange(handlers_, {});  // they may own this handle
  }

  // Of the network thread.
  void CountSent(std::size_t bytes) {
    bytes_ -= bytes;
    --messages_;
  }
  // Whether the session is to pause until Resume().
  bool CountReceived(std::size_t weight) { return (pending_ += weight) >= kWindow; }

 private:
  const std::weak_ptr<WebSocketSession> session_;  // locked on the network thread only
  const std::shared_ptr<Mailbox> mailbox_;
  const std::size_t max_queue_;
  const Request request_;
  const std::string subprotocol_;
  WebSocketHandlers handlers_;          // loop
  bool closing_ = false;                // loop
  std::atomic<std::size_t> bytes_ = 0;  // in the queue
  std::atomic<std::size_t> messages_ = 0;
  std::atomic<std::size_t> pending_ = 0;  // weight of what the loop has not handled
};

// Of the network thread.
class WebSocketSession final : public Session,
                               public std::enable_shared_from_this<WebSocketSession> {
 public:
  WebSocketSession(Network& network, net::ip::tcp::socket socket)
      : network_(network), stream_(std::move(socket)), timer_(network.io) {}

  void Start(Upgrade upgrade);

  Phase phase() const override { return closing_ ? Phase::kClosing : Phase::kBusy; }
  Time since() const override { return {}; }
  void Shutdown() override { Close(websocket::close_code::going_away, "the server ends", true); }
  void Abort() override { End(); }

  void Send(std::shared_ptr<const std::string> message, bool binary);
  void Ping(const std::string& payload);
  void Close(unsigned code, const std::string& reason, bool at_once);
  void Resume();

 private:
  struct Item {
    std::shared_ptr<const std::string> message;
    bool binary;
  };

  void OnOpen();
  void Read();
  void OnRead(const ErrorCode& error, std::size_t size);
  void OnPong(const std::string& payload);
  void Write();
  void OnWritten(const ErrorCode& error);
  void SendClose();
  void End();
  // Until the session and its handle are connected to the loop no longer.
  void PostToLoop(std::function<void(Handle&)> work) {
    Dispatch::Post(network_.dispatch,
                   [handle = handle_, work = std::move(work)] { work(*handle); });
  }

  Network& network_;
  websocket::stream<net::ip::tcp::socket> stream_;
  net::steady_timer timer_;
  beast::http::request<beast::http::empty_body> handshake_;
  std::shared_ptr<Handle> handle_;
  std::array<char, 16384> chunk_{};
  std::string message_;
  std::deque<Item> queue_;         // the first one is being written if writing_
  std::deque<std::string> pings_;  // without an answer, the last ones
  std::string reason_;
  unsigned code_ = 0;
  bool open_ = false;
  bool writing_ = false;
  bool pinging_ = false;
  bool paused_ = false;
  bool closing_ = false;
  bool close_sent_ = false;
  bool ended_ = false;
};

void Handle::Send(std::shared_ptr<const std::string> message, bool binary) {
  if (closing_ || !message) return;
  const std::size_t bytes = bytes_ + message->size();
  if (bytes + (messages_ + 1) * kMessageCost > max_queue_) {
    closing_ = true;
    mailbox_->Post([session = session_] {
      const auto alive = session.lock();
      if (alive) alive->Close(1013, "the client reads too slowly", true);
    });
    return;
  }
  bytes_ += message->size();
  ++messages_;
  mailbox_->Post([session = session_, message = std::move(message), binary]() mutable {
    const auto alive = session.lock();
    if (alive) alive->Send(std::move(message), binary);
  });
}

void Handle::Ping(std::string payload) {
  if (closing_) return;
  mailbox_->Post([session = session_, payload = std::move(payload)] {
    const auto alive = session.lock();
    if (alive) alive->Ping(payload);
  });
}

void Handle::Close(unsigned code, std::string reason) {
  if (closing_) return;
  closing_ = true;
  mailbox_->Post([session = session_, code, reason = std::move(reason)] {
    const auto alive = session.lock();
    if (alive) alive->Close(code, reason, false);
  });
}

void Handle::OnMessage(std::string message, bool binary, std::size_t weight) {
  if (!closing_ && handlers_.on_message) handlers_.on_message(std::move(message), binary);
  const std::size_t before = pending_.fetch_sub(weight);
  const bool halfway = before > kWindow / 2 && before - weight <= kWindow / 2;
  if (!halfway) return;
  mailbox_->Post([session = session_] {
    const auto alive = session.lock();
    if (alive) alive->Resume();
  });
}

void Handle::OnClosed() {
  closing_ = true;
  const WebSocketHandlers handlers = std::exchange(handlers_, {});  // they may own this handle
  if (handlers.on_closed) handlers.on_closed();
}

void WebSocketSession::Start(Upgrade upgrade) {
  ErrorCode ignored;
  stream_.next_layer().set_option(net::ip::tcp::no_delay(true), ignored);
  // What waits in the kernel stands before a ping and a stop: on a slow link some seconds of
  // pictures.
  static_cast<void>(setsockopt(stream_.next_layer().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT,
                               &kMostUnsent, sizeof(kMostUnsent)));
  websocket::stream_base::timeout timeout{};
  timeout.handshake_timeout = network_.options.header_timeout;
  timeout.idle_timeout = network_.options.idle_timeout;
  timeout.keep_alive_pings = true;
  stream_.set_option(timeout);
  stream_.set_option(websocket::stream_base::decorator(
      [subprotocol = upgrade.subprotocol](websocket::response_type& response) {
        if (!subprotocol.empty()) response.set("Sec-WebSocket-Protocol", subprotocol);
      }));
  stream_.read_message_max(network_.options.max_message);
  stream_.auto_fragment(false);
  handshake_.method(beast::http::verb::get);
  handshake_.target("/");
  handshake_.version(11);
  handshake_.set(beast::http::field::host, upgrade.request.headers["host"]);
  handshake_.set(beast::http::field::upgrade, "websocket");
  handshake_.set(beast::http::field::connection, "Upgrade");
  handshake_.set(beast::http::field::sec_websocket_version, "13");
  handshake_.set(beast::http::field::sec_websocket_key, upgrade.key);
  handle_ = std::make_shared<Handle>(weak_from_this(), network_, std::move(upgrade.request),
                                     std::move(upgrade.subprotocol));
  stream_.async_accept(handshake_, [self = shared_from_this()](const ErrorCode& error) {
    if (error) return self->End();
    self->OnOpen();
  });
}

void WebSocketSession::OnOpen() {
  if (ended_) return;
  open_ = true;
  Dispatch::Post(network_.dispatch, [handle = handle_, dispatch = network_.dispatch] {
    dispatch->Add(handle);
    handle->SetHandlers(dispatch->on_websocket(handle));
  });
  if (closing_) return SendClose();
  stream_.control_callback([this](websocket::frame_type kind, beast::string_view payload) {
    if (kind == websocket::frame_type::pong) OnPong({payload.data(), payload.size()});
  });
  Read();
}

void WebSocketSession::Read() {
  stream_.async_read_some(net::buffer(chunk_),
                          [self = shared_from_this()](const ErrorCode& error, std::size_t size) {
                            self->OnRead(error, size);
                          });
}

void WebSocketSession::OnRead(const ErrorCode& error, std::size_t size) {
  if (ended_) return;
  // The close operation reads the rest itself.
  if (error) return close_sent_ ? void() : End();
  message_.append(chunk_.data(), size);
  if (!stream_.is_message_done()) return Read();
  const std::size_t share = kWindow * message_.size() / (network_.options.max_message + 1);
  const std::size_t weight = 1 + share;
  paused_ = handle_->CountReceived(weight);
  PostToLoop([message = std::move(message_), binary = stream_.got_binary(), weight](
                 Handle& handle) mutable { handle.OnMessage(std::move(message), binary, weight); });
  message_.clear();
  if (!paused_) Read();
}

// At most one for each ping, whatever the client sends. An answer answers the pings before it, too.
void WebSocketSession::OnPong(const std::string& payload) {
  const auto answered = std::find(pings_.begin(), pings_.end(), payload);
  if (answered == pings_.end() || ended_) return;
  pings_.erase(pings_.begin(), std::next(answered));
  PostToLoop([payload](const Handle& handle) { handle.OnPong(payload); });
}

void WebSocketSession::Ping(const std::string& payload) {
  if (pinging_ || !open_ || closing_ || ended_) return;
  if (pings_.size() >= kMostPings) pings_.pop_front();
  pings_.push_back(payload);
  pinging_ = true;
  websocket::ping_data data;
  data.assign(payload.data(), payload.size());
  stream_.async_ping(data, [self = shared_from_this()](const ErrorCode& error) {
    self->pinging_ = false;
    if (error && !self->close_sent_) self->End();
  });
}

void WebSocketSession::Resume() {
  if (!paused_ || ended_ || close_sent_) return;
  paused_ = false;
  Read();
}

void WebSocketSession::Send(std::shared_ptr<const std::string> message, bool binary) {
  if (ended_ || closing_) return;
  queue_.push_back({std::move(message), binary});
  Write();
}

void WebSocketSession::Write() {
  if (writing_ || queue_.empty() || !open_ || close_sent_) return;
  writing_ = true;
  stream_.binary(queue_.front().binary);
  stream_.async_write(
      net::buffer(*queue_.front().message),
      [self = shared_from_this()](const ErrorCode& error, std::size_t) { self->OnWritten(error); });
}

void WebSocketSession::OnWritten(const ErrorCode& error) {
  writing_ = false;
  if (ended_) return;
  if (error) return close_sent_ ? void() : End();
  handle_->CountSent(queue_.front().message->size());
  queue_.pop_front();
  if (!queue_.empty()) return Write();
  if (closing_) return SendClose();
  PostToLoop([](const Handle& handle) { handle.OnDrained(); });
}

// `at_once`: without what is queued but for the message that is being written.
void WebSocketSession::Close(unsigned code, const std::string& reason, bool at_once) {
  if (closing_ || ended_) return;
  closing_ = true;
  code_ = code;
  reason_ = reason;
  if (at_once) queue_.resize(std::min<std::size_t>(queue_.size(), writing_ ? 1 : 0));
  timer_.expires_after(network_.ending ? kCloseTimeout / 4 : kCloseTimeout);
  timer_.async_wait([self = shared_from_this()](const ErrorCode& error) {
    if (!error) self->End();
  });
  if (open_ && queue_.empty()) SendClose();
}

void WebSocketSession::SendClose() {
  if (close_sent_) return;
  close_sent_ = true;
  constexpr std::size_t kMaxReason = 123;  // bytes; a control frame has no more
  std::size_t length = std::min(reason_.size(), kMaxReason);
  while (length < reason_.size() && (reason_[length] & 0xC0) == 0x80) --length;  // whole characters
  reason_.resize(length);
  stream_.async_close(websocket::close_reason(static_cast<websocket::close_code>(code_), reason_),
                      [self = shared_from_this()](const ErrorCode&) { self->End(); });
}

void WebSocketSession::End() {
  if (ended_) return;
  ended_ = true;
  closing_ = true;
  timer_.cancel();
  ErrorCode ignored;
  stream_.next_layer().close(ignored);
  if (open_) {
    Dispatch::Post(network_.dispatch, [handle = handle_, dispatch = network_.dispatch] {
      dispatch->Remove(handle);
      handle->OnClosed();
    });
  }
  network_.Remove(shared_from_this());
}

}  // namespace

void StartWebSocketSession(Network& network, Upgrade upgrade) {
  net::ip::tcp::socket socket(network.io);
  ErrorCode error;
  socket.assign(upgrade.six ? net::ip::tcp::v6() : net::ip::tcp::v4(), upgrade.socket, error);
  if (error) return;
  auto session = std::make_shared<WebSocketSession>(network, std::move(socket));
  network.Add(session);
  session->Start(std::move(upgrade));
}

}  // namespace musher::http
