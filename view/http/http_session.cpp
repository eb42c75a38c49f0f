#include <sys/socket.h>

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <ctime>
#include <optional>
#include <tuple>

#include "musher/view/http/head.hpp"
#include "musher/view/http/reply.hpp"
#include "musher/view/http/session.hpp"
#include "musher/view/http/target.hpp"

namespace musher::http {
namespace {

namespace net = boost::asio;
namespace http = boost::beast::http;
using ErrorCode = boost::system::error_code;
using Parser = http::request_parser<http::string_body>;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kMaxHead = 16384;  // bytes
constexpr std::size_t kMaxRequestLine = kMaxTarget + 64;
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";

// Reads one request at a time, so that responses are in the order of the requests and a client that
// sends more than it reads has to wait.
//
//   kWaiting -> kHead -> kBody -> kHandling -> kWriting -> kWaiting
//   kHead, kBody -> (refused) kWriting -> kLingering -> end
class HttpSession final : public Session, public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(Network& network, net::ip::tcp::socket socket)
      : network_(network), socket_(std::move(socket)), timer_(network.io) {}

  void Start(bool refuse);

  Phase phase() const override;
  Time since() const override { return since_; }
  void Shutdown() override;
  void Abort() override { End(); }

  // The response to request `number`; one to an earlier request is left out.
  void Respond(std::uint64_t number, Response response);

 private:
  enum class State { kWaiting, kHead, kBody, kHandling, kWriting, kLingering, kEnded };

  void SetDeadline(Duration after);
  void OnDeadline();
  void Read();
  void OnRead(const ErrorCode& error, std::size_t size);
  void Parse();
  bool ParseHead();
  void ParseBody();
  void RefuseMalformed(const ErrorCode& error);
  bool OnHead();
  void StartUpgrade(CheckedHead head);
  void HandleRequest();
  void Refuse(unsigned status, const Error& error);
  void Write(Response response, bool close);
  void OnWritten(const ErrorCode& error);
  void NextRequest();
  void Linger();
  void End();

  Network& network_;
  net::ip::tcp::socket socket_;
  net::steady_timer timer_;
  bool timed_ = false;  // a wait of timer_ is under way
  State state_ = State::kWaiting;
  Time since_ = Clock::now();
  Time deadline_{};
  std::array<char, 8192> chunk_{};
  std::string buffer_;  // received and not parsed yet
  std::optional<Parser> parser_;
  CheckedHead head_;
  std::uint64_t number_ = 0;  // of complete requests
  std::string reply_head_;
  Response response_;
  bool close_ = false;  // after the response
};

// Answers 500 unless it is called.
class Responder {
 public:
  Responder(std::weak_ptr<HttpSession> session, std::uint64_t number,
            std::shared_ptr<Mailbox> mailbox)
      : session_(std::move(session)), number_(number), mailbox_(std::move(mailbox)) {}
  ~Responder() { Call(ErrorResponse(500, kCodeFailed, "the server dropped the request")); }
  Responder(const Responder&) = delete;
  Responder& operator=(const Responder&) = delete;

  void Call(Response response) {
    if (done_) return;
    done_ = true;
    mailbox_->Post([session = session_, number = number_, response = std::move(response)] {
      const auto alive = session.lock();
      if (alive) alive->Respond(number, response);
    });
  }

 private:
  const std::weak_ptr<HttpSession> session_;  // locked on the network thread only
  const std::uint64_t number_;
  const std::shared_ptr<Mailbox> mailbox_;
  bool done_ = false;
};

void HttpSession::Start(bool refuse) {
  ErrorCode ignored;
  socket_.set_option(net::ip::tcp::no_delay(true), ignored);
  if (refuse) {
    return Refuse(503, {kCodeTargetBusy, "the server has as many connections as it may have (" +
                                             std::to_string(network_.options.max_connections) +
                                             "); try again later"});
  }
  SetDeadline(network_.options.header_timeout);
  Read();
}

Session::Phase HttpSession::phase() const {
  switch (state_) {
    case State::kHandling:
      return Phase::kBusy;
    case State::kWriting:
      return close_ ? Phase::kClosing : Phase::kBusy;
    case State::kLingering:
    case State::kEnded:
      return Phase::kClosing;
    default:
      return number_ == 0 ? Phase::kSilent : Phase::kIdle;
  }
}

// A deadline is mostly moved further, so the timer is set again only once it has fired.
void HttpSession::SetDeadline(Duration after) {
  deadline_ = Clock::now() + after;
  if (timed_ && timer_.expiry() <= deadline_) return;
  timed_ = true;
  timer_.expires_at(deadline_);
  timer_.async_wait([self = shared_from_this()](const ErrorCode& error) {
    if (!error) self->OnDeadline();
  });
}

void HttpSession::OnDeadline() {
  timed_ = false;
  if (state_ == State::kEnded || state_ == State::kHandling) return;
  const Time now = Clock::now();
  if (deadline_ > now) return SetDeadline(deadline_ - now);
  if (state_ != State::kHead && state_ != State::kBody) return End();
  Refuse(408, {kCodeTimeout, "the request is not complete in time"});
}

void HttpSession::Read() {
  socket_.async_read_some(net::buffer(chunk_),
                          [self = shared_from_this()](const ErrorCode& error, std::size_t size) {
                            self->OnRead(error, size);
                          });
}

void HttpSession::OnRead(const ErrorCode& error, std::size_t size) {
  if (state_ == State::kEnded) return;
  if (error == net::error::operation_aborted) return;
  if (state_ == State::kLingering) return error ? End() : Read();  // and drops it
  if (state_ == State::kWriting) return;                           // a refusal meanwhile
  if (error) return End();
  since_ = Clock::now();
  buffer_.append(chunk_.data(), size);
  Parse();
}

void HttpSession::Parse() {
  if (state_ == State::kWaiting) {
    state_ = State::kHead;
    if (number_ > 0) SetDeadline(network_.options.header_timeout);
    parser_.emplace();
    parser_->header_limit(kMaxHead);
    parser_->body_limit(network_.options.max_body);
  }
  if (state_ == State::kHead && !ParseHead()) return;
  ParseBody();
}

// Whether the body is next.
bool HttpSession::ParseHead() {
  ErrorCode error;
  const std::size_t used = parser_->put(net::buffer(buffer_), error);
  buffer_.erase(0, used);
  if (error == http::error::need_more) {
    const bool long_line = parser_->get().target().empty() && buffer_.size() > kMaxRequestLine;
    if (!long_line) return Read(), false;
    Refuse(414, {kCodeParametersInvalid,
                 "the address is longer than " + std::to_string(kMaxTarget) + " bytes"});
    return false;
  }
  if (error) return RefuseMalformed(error), false;
  return OnHead();
}

void HttpSession::ParseBody() {
  ErrorCode error;
  while (!parser_->is_done() && !buffer_.empty()) {
    const std::size_t used = parser_->put(net::buffer(buffer_), error);
    buffer_.erase(0, used);
    if (error == http::error::need_more) return Read();
    if (error) return RefuseMalformed(error);
  }
  if (!parser_->is_done()) return Read();
  HandleRequest();
}

void HttpSession::RefuseMalformed(const ErrorCode& error) {
  if (error == http::error::body_limit) {
    return Refuse(
        413, {kCodeParametersInvalid,
              "the body is larger than " + std::to_string(network_.options.max_body) + " bytes"});
  }
  if (error == http::error::header_limit) {
    return Refuse(431, {kCodeParametersInvalid,
                        "the header is larger than " + std::to_string(kMaxHead) + " bytes"});
  }
  Refuse(400, {kCodeParametersInvalid, "the request is malformed: " + error.message()});
}

// Whether the body is next.
bool HttpSession::OnHead() {
  Head head;
  const auto& message = parser_->get();
  head.method = std::string(message.method_string());
  head.target = std::string(message.target());
  for (const auto& field : message) {
    head.fields.emplace_back(std::string(field.name_string()), std::string(field.value()));
  }
  ErrorCode error;
  Connection connection;
  connection.local_address = socket_.local_endpoint(error).address().to_string();
  const auto peer = socket_.remote_endpoint(error);
  if (error) return End(), false;  // it is closed already
  auto checked = CheckHead(head, connection, network_.names, network_.options.subprotocols);
  if (const auto* refusal = std::get_if<HttpError>(&checked)) {
    Refuse(refusal->status, refusal->error);
    return false;
  }
  head_ = std::get<CheckedHead>(std::move(checked));
  head_.request.peer = peer.address().to_string();
  constexpr std::string_view kMapped = "::ffff:";  // IPv4 on a socket of IPv6
  if (head_.request.peer.starts_with(kMapped)) head_.request.peer.erase(0, kMapped.size());
  const bool from_here = IsLoopback(head_.request.peer);
  const std::string client = from_here ? ForwardedAddress(head_.request) : std::string();
  if (!client.empty()) head_.request.peer = client + " through a proxy";
  head_.request.local = head_.request.local && from_here;
  if (head_.websocket) {
    StartUpgrade(std::move(head_));
    return false;
  }
  state_ = State::kBody;
  SetDeadline(network_.options.idle_timeout);
  if (head_.expects_continue && !parser_->is_done() && buffer_.empty()) {
    // Fits into an empty buffer; if not, the client sends the body all the same after a while.
    std::ignore = send(socket_.native_handle(), kContinue.data(), kContinue.size(),
                       MSG_DONTWAIT | MSG_NOSIGNAL);
  }
  parser_->eager(true);
  return true;
}

void HttpSession::StartUpgrade(CheckedHead head) {
  if (!buffer_.empty() || !parser_->is_done()) {
    return Refuse(400, {kCodeParametersInvalid, "bytes follow before the WebSocket is open"});
  }
  ErrorCode error;
  Upgrade upgrade;
  upgrade.six = socket_.local_endpoint(error).protocol() == net::ip::tcp::v6();
  upgrade.key = std::move(head.key);
  upgrade.subprotocol = std::move(head.subprotocol);
  upgrade.request = std::move(head.request);
  upgrade.socket = socket_.release(error);
  End();
  if (!error) StartWebSocketSession(network_, std::move(upgrade));
}

void HttpSession::HandleRequest() {
  state_ = State::kHandling;
  ++number_;
  head_.request.body = std::move(parser_->get().body());
  close_ = !parser_->get().keep_alive() || parser_->get().version() < 11;
  parser_.reset();
  if (network_.ending) return Refuse(503, {kCodeStateInvalid, "the server ends"});
  auto responder = std::make_shared<Responder>(weak_from_this(), number_, network_.mailbox);
  auto request = std::make_shared<Request>(head_.request);
  Dispatch::Post(network_.dispatch, [dispatch = network_.dispatch, request, responder] {
    dispatch->on_request(std::move(*request),
                         [responder](Response response) { responder->Call(std::move(response)); });
  });
}

void HttpSession::Respond(std::uint64_t number, Response response) {
  if (state_ != State::kHandling || number != number_) return;
  Write(std::move(response), close_ || network_.ending);
}

void HttpSession::Refuse(unsigned status, const Error& error) {
  Response response = ErrorResponse(status, error.code, error.message);
  if (status == 405) response.headers.emplace_back("Allow", "GET, HEAD, POST");
  if (status == 426) response.headers.emplace_back("Sec-WebSocket-Version", "13");
  if (status == 503) response.headers.emplace_back("Retry-After", "5");
  Write(std::move(response), true);
}

void HttpSession::Write(Response response, bool close) {
  state_ = State::kWriting;
  close_ = close;
  response_ = std::move(response);
  ReplyContext context;
  context.path = head_.request.path;
  context.close = close_;
  context.unix_s = std::time(nullptr);
  reply_head_ = ReplyHead(response_, context);
  SetDeadline(network_.options.idle_timeout);
  std::array<net::const_buffer, 2> parts = {net::buffer(reply_head_), net::const_buffer()};
  if (response_.body && HasBody(response_.status) && !head_.without_body) {
    parts[1] = net::buffer(*response_.body);
  }
  net::async_write(
      socket_, parts,
      [self = shared_from_this()](const ErrorCode& error, std::size_t) { self->OnWritten(error); });
}

void HttpSession::OnWritten(const ErrorCode& error) {
  if (state_ != State::kWriting) return;
  if (error) return End();
  response_ = {};
  if (close_) return Linger();
  NextRequest();
}

void HttpSession::NextRequest() {
  if (network_.ending) return End();
  state_ = State::kWaiting;
  head_ = {};
  since_ = Clock::now();
  SetDeadline(network_.options.idle_timeout);
  if (buffer_.empty()) return Read();
  Parse();
}

// Closing a socket with unread bytes makes the kernel discard the response, so these are read
// first.
void HttpSession::Linger() {
  state_ = State::kLingering;
  ErrorCode ignored;
  socket_.shutdown(net::ip::tcp::socket::shutdown_send, ignored);
  socket_.cancel(ignored);  // a read that the refusal overtook
  SetDeadline(kCloseTimeout);
  Read();
}

void HttpSession::Shutdown() {
  if (state_ == State::kWriting || state_ == State::kLingering) return;
  if (state_ == State::kHandling) return Refuse(503, {kCodeStateInvalid, "the server ends"});
  End();
}

void HttpSession::End() {
  if (state_ == State::kEnded) return;
  state_ = State::kEnded;
  ErrorCode ignored;
  timer_.cancel(ignored);
  socket_.close(ignored);
  network_.Remove(shared_from_this());
}

}  // namespace

void StartHttpSession(Network& network, int socket, bool refuse) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  ErrorCode error;
  net::ip::tcp::socket taken(network.io);
  const bool known = getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length) == 0;
  const bool six = known && address.ss_family == AF_INET6;
  taken.assign(six ? net::ip::tcp::v6() : net::ip::tcp::v4(), socket, error);
  if (error) return;
  auto session = std::make_shared<HttpSession>(network, std::move(taken));
  network.Add(session);
  session->Start(refuse);
}

}  // namespace musher::http
