#pragma once
// Calls between two processes of one host, by a socket of the kernel: without discovery, and
// whatever the network does. For clients that run beside the controller.
//
//   server                          client
//   HostServer::Make(loop, name)
//   Offer<msg::GetStatus>(…)        HostCall::Make(loop, name, service, request, on_reply)
//                     ◀── one packet: the service's name, a zero byte, the request ──
//                     ──── one packet: the request is taken ────────────────────────▶
//                     ──── one packet: the reply, or a descriptor of its file, ─────▶
//                          or why there is none
//
// A call is one connection, which the server closes after the reply. Closed before the request is
// taken, nothing was done: there is no such service, or there are too many calls. A client only
// trusts a server of root or of its own user. The server takes requests of every user of the host,
// as it does by DDS without credentials. Containers reach each other if they share the network
// namespace.
//
// Threads: loop thread only.

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/messages/cdr.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport {

class HostServer {
 public:
  // Answers one request, now or later. A second answer does nothing, nor does an answer to a caller
  // that has exited.
  using Reply = std::function<void(const msg::Bytes&)>;
  using Handler = std::function<void(std::span<const std::byte> request, Reply reply)>;

  // `name`: as of a NameLock. Fails if a process has it. `loop` must outlive the server.
  static Result<std::unique_ptr<HostServer>> Make(EventLoop& loop, std::string_view name);

  void Offer(const std::string& service, Handler handler) {
    handlers_[service] = std::move(handler);
  }
  template <msg::Service S>
  void Offer(const std::string& service, typename Server<S>::HandlerOfCaller handler);

 private:
  struct Connection {
    UniqueFd socket;
    LoopHandlePtr watch;  // before `socket` goes
    ~Connection() { watch = nullptr; }
  };

  HostServer(EventLoop& loop, UniqueFd socket) : loop_(loop), socket_(std::move(socket)) {}
  void Accept();
  void Read(int id);

  EventLoop& loop_;
  UniqueFd socket_;
  LoopHandlePtr watch_;
  std::map<std::string, Handler> handlers_;
  int last_ = 0;
  // Shared with the replies, which may come after the server's end.
  std::shared_ptr<std::map<int, Connection>> connections_ =
      std::make_shared<std::map<int, Connection>>();
};

// One call. Dropping it ends it: then its callback does not run.
class HostCall {
 public:
  // Runs once on the loop, never inside Make(): with the reply, or an Error. kCodeUnSupport: the
  // server has not taken the request. kCodeNetError: it has, and has ended before its reply.
  // kCodeFailed: it has, and its reply does not arrive; the message says why.
  using OnReply = std::function<void(Result<msg::Bytes>)>;

  // Null: no process listens at `name`, or it is not trusted.
  static std::unique_ptr<HostCall> Make(EventLoop& loop, std::string_view name,
                                        std::string_view service,
                                        std::span<const std::byte> request, OnReply on_reply);

  // The pid of the process that is called.
  pid_t server() const { return server_; }

 private:
  HostCall(UniqueFd socket, pid_t server, OnReply on_reply)
      : socket_(std::move(socket)), server_(server), on_reply_(std::move(on_reply)) {}
  void Read();

  UniqueFd socket_;
  const pid_t server_;
  OnReply on_reply_;
  bool taken_ = false;
  LoopHandlePtr watch_;
};

template <msg::Service S>
void HostServer::Offer(const std::string& service, typename Server<S>::HandlerOfCaller handler) {
  Offer(service, [handler = std::move(handler)](std::span<const std::byte> bytes, Reply reply) {
    typename S::Request request{};
    if (!internal::DecodeEnvelope(bytes, request)) return reply({});  // malformed, too
    const auto answer = [reply = std::move(reply)](const typename S::Response& response) {
      reply(internal::EncodeEnvelope({}, response));
    };
    handler(request, answer, ParticipantId(0));
  });
}

// The reply of a service to an encoded one.
template <msg::Service S>
Result<typename S::Response> DecodeReply(const Result<msg::Bytes>& bytes) {
  if (!bytes) return bytes.error();
  typename S::Response response{};
  if (internal::DecodeEnvelope(bytes.value(), response)) return response;
  return Error{kCodeNetError, "the reply is malformed"};
}

}  // namespace musher::transport
