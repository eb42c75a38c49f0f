#include "musher/application/groot2/groot2_server.hpp"

#include <zmq.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <iterator>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "musher/application/groot2/groot2_session.hpp"

namespace musher::groot2 {
namespace {

constexpr int kPollMs = 100;
constexpr std::chrono::milliseconds kSlice(5);    // of a wait for the loop
constexpr std::chrono::seconds kLongestWait(2);   // for a loop that is busy
constexpr std::int64_t kLargestPart = 64 * 1024;  // bytes, of a request

struct CloseSocket {
  void operator()(void* socket) const { zmq_close(socket); }
};
struct EndContext {
  void operator()(void* context) const { zmq_ctx_term(context); }
};
using Context = std::unique_ptr<void, EndContext>;
using Socket = std::unique_ptr<void, CloseSocket>;

Error ZmqError(const std::string& what) {
  return {kCodeFailed, what + ": " + zmq_strerror(zmq_errno())};
}

Result<Socket> Bind(void* context, int type, const std::string& address) {
  Socket socket(zmq_socket(context, type));
  if (!socket) return ZmqError("no socket for Groot2");
  const int now = 0;
  zmq_setsockopt(socket.get(), ZMQ_LINGER, &now, sizeof now);
  zmq_setsockopt(socket.get(), ZMQ_MAXMSGSIZE, &kLargestPart, sizeof kLargestPart);
  if (zmq_bind(socket.get(), address.c_str()) != 0) {
    return ZmqError("Groot2 can not be served on " + address);
  }
  return socket;
}

void Send(void* socket, const Parts& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const int more = i + 1 < parts.size() ? ZMQ_SNDMORE : 0;
    if (zmq_send(socket, parts[i].data(), parts[i].size(), ZMQ_DONTWAIT | more) < 0) {
      return;  // the client is lost
    }
  }
}

class Server {
 public:
  Server(transport::EventLoop& loop, Context context, Socket replies,
         std::shared_ptr<Session> session, Duration silence)
      : loop_(loop),
        context_(std::move(context)),
        replies_(std::move(replies)),
        session_(std::move(session)),
        silence_(silence),
        thread_([this] { Run(); }) {}
  ~Server() {
    ends_ = true;
    thread_.join();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

 private:
  void Run() {
    while (!ends_) {
      zmq_pollitem_t readable{replies_.get(), 0, ZMQ_POLLIN, 0};
      if (zmq_poll(&readable, 1, kPollMs) > 0) Serve(Receive());
      ForgetLater();
    }
  }

  // `parts` of a ROUTER socket: the identity of the connection, further parts of the client's
  // envelope, an empty part, the request.
  void Serve(const Parts& parts) {
    const auto empty = std::ranges::find(parts, std::string());
    if (empty == parts.begin() || empty == parts.end()) return;  // no request of this protocol
    const std::string& client = parts.front();
    const Parts reply = ReplyOnLoop(client, Parts(std::next(empty), parts.end()));
    last_requests_[client] = Clock::now();
    Parts answer(parts.begin(), std::next(empty));
    answer.insert(answer.end(), reply.begin(), reply.end());
    Send(replies_.get(), answer);
  }

  // Clients that are lost, as far as can be known.
  void ForgetLater() {
    const auto now = Clock::now();
    std::erase_if(last_requests_, [&](const auto& last) {
      if (now - last.second < silence_) return false;
      loop_.Post([weak = std::weak_ptr<Session>(session_), client = last.first] {
        if (const auto session = weak.lock()) session->Forget(client);
      });
      return true;
    });
  }

  Parts Receive() {
    Parts parts;
    for (bool more = true; more;) {
      zmq_msg_t message;
      zmq_msg_init(&message);
      if (zmq_msg_recv(&message, replies_.get(), ZMQ_DONTWAIT) >= 0) {
        parts.emplace_back(static_cast<const char*>(zmq_msg_data(&message)),
                           zmq_msg_size(&message));
        more = zmq_msg_more(&message) != 0;
      } else {
        more = false;
      }
      zmq_msg_close(&message);
    }
    return parts;
  }

  // The loop carries a request out only where its client is not refused meanwhile.
  Parts ReplyOnLoop(const std::string& client, const Parts& request) {
    const auto work = std::make_shared<Work>();
    std::future<Parts> reply = work->reply.get_future();
    loop_.Post([work, client, request, weak = std::weak_ptr<Session>(session_)] {
      if (work->decided.exchange(true)) return;
      const auto session = weak.lock();
      work->reply.set_value(session ? session->Reply(client, request) : kBusy);
    });
    const auto deadline = Clock::now() + kLongestWait;
    while (reply.wait_for(kSlice) != std::future_status::ready) {
      const bool ends = ends_ || Clock::now() > deadline;
      if (ends && !work->decided.exchange(true)) return kBusy;
    }
    return reply.get();
  }

  using Clock = std::chrono::steady_clock;
  struct Work {
    std::promise<Parts> reply;
    std::atomic<bool> decided = false;  // the loop carries it out, or the client is refused
  };
  static inline const Parts kBusy = {"error", "the robot's loop is busy"};

  transport::EventLoop& loop_;
  const Context context_;  // before the sockets, also that of the session
  const Socket replies_;
  const std::shared_ptr<Session> session_;
  const Duration silence_;
  std::map<std::string, Clock::time_point> last_requests_;  // of each client that is known
  std::atomic<bool> ends_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace

Result<> Serve(transport::Endpoints& topics, const ServeOptions& options,
               std::function<TreeView()> view, const tree::Factory& factory) {
  Context context(zmq_ctx_new());
  if (!context) return ZmqError("no context for Groot2");
  const std::string host = "tcp://" + options.address + ":";
  Result<Socket> replies = Bind(context.get(), ZMQ_ROUTER, host + std::to_string(options.port));
  if (!replies) return replies.error();
  Result<Socket> breakpoints =
      Bind(context.get(), ZMQ_PUB, host + std::to_string(options.port + 1));
  if (!breakpoints) return breakpoints.error();
  // Only the loop publishes.
  const auto publisher = std::make_shared<Socket>(std::move(breakpoints).value());
  const auto session = std::make_shared<Session>(
      std::move(view), factory,
      Session::Options{
          .hooks = options.hooks,
          .publish = [publisher](const Parts& parts) { Send(publisher->get(), parts); },
          .on_lost = options.on_lost});
  topics.Keep(std::make_shared<Server>(topics.node().loop(), std::move(context),
                                       std::move(replies).value(), session, options.silence));
  return Ok();
}

}  // namespace musher::groot2
