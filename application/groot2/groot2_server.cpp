#include "musher/application/groot2/groot2_server.hpp"

#include <zmq.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <random>
#include <thread>
#include <utility>

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

// On the loop: what replies.
class Replying {
 public:
  Replying(std::function<TreeView()> view, const tree::Factory& factory)
      : view_(std::move(view)), factory_(factory) {}

  Parts To(const Parts& request) {
    const TreeView view = view_();
    if (view.revision != revision_) {  // another tree has another id, so that Groot2 reads it again
      revision_ = view.revision;
      for (char& byte : id_) byte = static_cast<char>(random_());
    }
    return Reply(request, view, factory_, id_);
  }

 private:
  const std::function<TreeView()> view_;
  const tree::Factory& factory_;
  std::random_device random_;
  std::optional<std::uint32_t> revision_;
  TreeId id_{};
};

class Server {
 public:
  Server(transport::EventLoop& loop, std::shared_ptr<Replying> replying, Context context,
         Socket replies, Socket breakpoints)
      : loop_(loop),
        replying_(std::move(replying)),
        context_(std::move(context)),
        replies_(std::move(replies)),
        breakpoints_(std::move(breakpoints)),
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
      if (zmq_poll(&readable, 1, kPollMs) <= 0) continue;
      const Parts request = Receive();
      Send(AskLoop(request));
    }
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

  Parts AskLoop(const Parts& request) {
    const auto promise = std::make_shared<std::promise<Parts>>();
    std::future<Parts> reply = promise->get_future();
    loop_.Post([promise, request, weak = std::weak_ptr<Replying>(replying_)] {
      if (const auto replying = weak.lock()) promise->set_value(replying->To(request));
    });
    const auto deadline = std::chrono::steady_clock::now() + kLongestWait;
    while (reply.wait_for(kSlice) != std::future_status::ready) {
      if (ends_ || std::chrono::steady_clock::now() > deadline) {
        return {"error", "the robot's loop is busy"};
      }
    }
    return reply.get();
  }

  void Send(const Parts& parts) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const int more = i + 1 < parts.size() ? ZMQ_SNDMORE : 0;
      if (zmq_send(replies_.get(), parts[i].data(), parts[i].size(), ZMQ_DONTWAIT | more) < 0) {
        return;  // the client is lost
      }
    }
  }

  transport::EventLoop& loop_;
  const std::shared_ptr<Replying> replying_;
  const Context context_;
  const Socket replies_;
  const Socket breakpoints_;  // Groot2 subscribes there; nothing is ever published
  std::atomic<bool> ends_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace

Result<> Serve(transport::Endpoints& topics, const ServeOptions& options,
               std::function<TreeView()> view, const tree::Factory& factory) {
  Context context(zmq_ctx_new());
  if (!context) return ZmqError("no context for Groot2");
  const std::string host = "tcp://" + options.address + ":";
  Result<Socket> replies = Bind(context.get(), ZMQ_REP, host + std::to_string(options.port));
  if (!replies) return replies.error();
  Result<Socket> breakpoints =
      Bind(context.get(), ZMQ_PUB, host + std::to_string(options.port + 1));
  if (!breakpoints) return breakpoints.error();
  topics.Keep(std::make_shared<Server>(
      topics.node().loop(), std::make_shared<Replying>(std::move(view), factory),
      std::move(context), std::move(replies).value(), std::move(breakpoints).value()));
  return Ok();
}

}  // namespace musher::groot2
