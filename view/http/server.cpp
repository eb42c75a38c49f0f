#include "musher/view/http/server.hpp"

#include <unistd.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <thread>

#include "musher/base/host.hpp"
#include "musher/view/http/session.hpp"
#include "musher/view/http/target.hpp"

namespace musher::http {
namespace {

namespace net = boost::asio;
using ErrorCode = boost::system::error_code;

// Connections beyond the limit that may receive a refusal at a time.
constexpr std::size_t kMaxRefusals = 32;

}  // namespace

void Dispatch::Post(const std::shared_ptr<Dispatch>& self, std::function<void()> work) {
  self->loop_.Post([self, work = std::move(work)] {
    if (self->alive_) work();
  });
}

void Dispatch::Stop() {
  alive_ = false;
  const auto endpoints = std::exchange(endpoints_, {});
  for (const auto& endpoint : endpoints) endpoint->Release();
}

void Mailbox::Post(std::function<void()> work) {
  const std::lock_guard lock(mutex_);
  if (network_ != nullptr) net::post(*network_, std::move(work));
}

void Mailbox::Close() {
  const std::lock_guard lock(mutex_);
  network_ = nullptr;
}

void Network::Add(std::shared_ptr<Session> session) {
  sessions.insert(std::move(session));
}

void Network::Remove(const std::shared_ptr<Session>& session) {
  sessions.erase(session);
  if (ending && sessions.empty()) io.stop();
}

// Its functions but the constructor and the destructor run on the network thread.
class Server::Impl {
 public:
  Impl(transport::EventLoop& loop, const Options& options, OnRequest on_request,
       OnWebSocket on_websocket)
      : network_{io_,
                 options,
                 HostNames{LowerCase(HostName()), options.hosts},
                 std::make_shared<Dispatch>(loop, std::move(on_request), std::move(on_websocket)),
                 std::make_shared<Mailbox>(io_),
                 {},
                 false},
        acceptor_(io_),
        timer_(io_) {}

  ~Impl() {
    network_.dispatch->Stop();
    if (!thread_.joinable()) return;
    network_.mailbox->Post([this] { End(); });
    thread_.join();
    network_.mailbox->Close();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<> Start();
  std::uint16_t port() const { return port_; }

 private:
  void Accept();
  void OnAccepted(const ErrorCode& error, net::ip::tcp::socket socket);
  bool MakeRoom();
  void End();

  net::io_context io_{1};
  Network network_;
  net::ip::tcp::acceptor acceptor_;
  net::steady_timer timer_;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

Result<> Server::Impl::Start() {
  const Options& options = network_.options;
  ErrorCode error;
  const auto address = net::ip::make_address(options.bind, error);
  if (error) {
    return Error{kCodeParametersInvalid, "'" + options.bind + "' is not an address"};
  }
  const net::ip::tcp::endpoint endpoint(address, options.port);
  const std::string what =
      "cannot listen on " + options.bind + " port " + std::to_string(options.port);
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(net::socket_base::reuse_address(true), error);
  if (!error && address.is_v6() && address.is_unspecified()) {
    acceptor_.set_option(net::ip::v6_only(false), error);
  }
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
  if (error) return SystemError(what, error.value());
  port_ = acceptor_.local_endpoint(error).port();
  Accept();
  // Signals are for the loop's thread.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { io_.run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return Ok();
}

void Server::Impl::Accept() {
  acceptor_.async_accept([this](const ErrorCode& error, net::ip::tcp::socket socket) {
    OnAccepted(error, std::move(socket));
  });
}

void Server::Impl::OnAccepted(const ErrorCode& error, net::ip::tcp::socket socket) {
  if (network_.ending) return;
  if (!error) {
    const bool room = MakeRoom();
    const bool answer =
        room || network_.sessions.size() < network_.options.max_connections + kMaxRefusals;
    ErrorCode ignored;
    if (answer) StartHttpSession(network_, socket.release(ignored), !room);
    return Accept();
  }
  const bool exhausted = error == net::error::no_descriptors || error.value() == ENFILE ||
                         error == net::error::no_buffer_space || error == net::error::no_memory;
  if (!exhausted) return Accept();
  timer_.expires_after(Milliseconds(100));
  timer_.async_wait([this](const ErrorCode& aborted) {
    if (!aborted) Accept();
  });
}

// Whether there is room for one more connection. If all places are taken, the one that has been
// silent for the longest time ends: first of those without a complete request, then of the idle.
bool Server::Impl::MakeRoom() {
  std::size_t count = 0;
  std::shared_ptr<Session> found;
  for (const auto& session : network_.sessions) {
    const auto phase = session->phase();
    if (phase == Session::Phase::kClosing) continue;
    ++count;
    if (phase == Session::Phase::kBusy) continue;
    const bool better = !found || phase < found->phase() ||
                        (phase == found->phase() && session->since() < found->since());
    if (better) found = session;
  }
  if (count < network_.options.max_connections) return true;
  if (!found) return false;
  found->Abort();
  return true;
}

void Server::Impl::End() {
  network_.ending = true;
  ErrorCode ignored;
  acceptor_.close(ignored);
  timer_.expires_after(kCloseTimeout / 2);
  timer_.async_wait([this](const ErrorCode&) { io_.stop(); });
  const auto sessions = network_.sessions;
  for (const auto& session : sessions) session->Shutdown();
  if (network_.sessions.empty()) io_.stop();
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::Make(transport::EventLoop& loop, const Options& options,
                                             OnRequest on_request, OnWebSocket on_websocket) {
  auto impl = std::make_unique<Impl>(loop, options, std::move(on_request), std::move(on_websocket));
  const auto started = impl->Start();
  if (!started) return started.error();
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

std::uint16_t Server::port() const {
  return impl_->port();
}

}  // namespace musher::http
