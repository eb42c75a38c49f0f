#pragma once
// Services as ROS 2 maps them on DDS: a request topic "rq/<name>Request" and a reply topic
// "rr/<name>Reply", whose samples start with the client's id and a sequence number.
//
// Two problems of the ROS 2 stack are avoided:
//   - A reply is held until the reader of the calling client is matched, so that it cannot be lost
//     between the two halves of discovery. (ROS 2 waits 100 ms and then drops it.)
//   - Every call ends: with the reply, or with a timeout at its deadline.
//
// Typed wrappers of RawClient and RawServer. Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/transport/node.hpp"
#include "musher/transport/raw_client.hpp"
#include "musher/transport/raw_server.hpp"

namespace musher::transport {

namespace internal {

template <class Body>
msg::Bytes EncodeEnvelope(const msg::RequestId& id, const Body& body) {
  msg::CdrWriter writer;
  writer.Put(id);
  writer.Put(body);
  return std::move(writer).Take();
}

// False if the bytes are not an id and a body.
template <class Body>
bool DecodeEnvelope(std::span<const std::byte> bytes, Body& body) {
  msg::CdrReader reader(bytes);
  msg::RequestId id;
  reader.Get(id);
  reader.Get(body);
  return reader.ok();
}

}  // namespace internal

template <msg::Service S>
class Client {
 public:
  using Request = typename S::Request;
  using Response = typename S::Response;
  using OnReply = std::function<void(Result<Response>)>;
  using Counts = std::function<bool(ParticipantId server, const Response& reply)>;

  explicit Client(std::unique_ptr<RawClient> raw) : raw_(std::move(raw)) {}

  // Whether a server is matched in both directions, so that a call sent now reaches it.
  bool Ready() const { return raw_->Ready(); }

  // The participants of those servers. A crashed one stays in the list until its lease expires; its
  // successor is another participant.
  std::vector<ParticipantId> Servers() const { return raw_->Servers(); }

  // Sends the request at once if a server is matched, else as soon as one is, but not later than
  // `timeout` from now, in which the time counts for which this computer is suspended. `on_reply`
  // runs exactly once on the loop: with the reply, with kCodeTimeout after `timeout`, or with the
  // reason why the request could not be sent. It never runs inside Call(). Dropping the client
  // drops its pending calls: their `on_reply` does not run. A service may have several servers, and
  // each receives the request. With `server`, it is sent once that participant's is matched, and
  // only a reply of that one counts. 0: any.
  void Call(const Request& request, Duration timeout, OnReply on_reply, ParticipantId server = 0) {
    const msg::RequestId id = raw_->NextId();
    raw_->Call(id, internal::EncodeEnvelope(id, request), timeout, Decoded(std::move(on_reply)),
               server);
  }
  // The same to every server, also to one that is matched later: it ends with the first reply of
  // which `counts` returns true. `counts` runs on the loop, with each reply until then, and the
  // participant that has sent it.
  void CallAll(const Request& request, Duration timeout, Counts counts, OnReply on_reply) {
    const msg::RequestId id = raw_->NextId();
    RawClient::Counts decoded = [counts = std::move(counts)](ParticipantId server,
                                                             std::span<const std::byte> reply) {
      Response response{};
      return internal::DecodeEnvelope(reply, response) && counts(server, response);
    };
    raw_->Call(id, internal::EncodeEnvelope(id, request), timeout, Decoded(std::move(on_reply)),
               /*server=*/0, std::move(decoded));
  }

 private:
  static RawClient::OnReply Decoded(OnReply on_reply) {
    return [on_reply = std::move(on_reply)](Result<std::span<const std::byte>> reply) {
      if (!reply) return on_reply(reply.error());
      Response response{};
      if (!internal::DecodeEnvelope(reply.value(), response)) {
        return on_reply(Error{kCodeNetError, "the reply is malformed"});
      }
      on_reply(std::move(response));
    };
  }

  std::unique_ptr<RawClient> raw_;
};

template <msg::Service S>
class Server {
 public:
  using Request = typename S::Request;
  using Response = typename S::Response;
  // Answers one request, now or later, on the loop; a second call and a call after the server is
  // dropped do nothing.
  using Reply = std::function<void(const Response&)>;
  using Handler = std::function<void(const Request&, Reply)>;
  // The same, with the calling participant.
  using HandlerOfCaller = std::function<void(const Request&, Reply, ParticipantId caller)>;

  explicit Server(std::unique_ptr<RawServer> raw) : raw_(std::move(raw)) {}

  // Requests that did not decode; replies that reached no client in time or could not be sent.
  std::uint64_t malformed() const { return raw_->malformed(); }
  std::uint64_t dropped() const { return raw_->dropped(); }
  // Whether a reply is held until the calling client is matched.
  bool Holds() const { return raw_->Holds(); }

 private:
  std::unique_ptr<RawServer> raw_;
};

template <msg::Service S>
Result<std::unique_ptr<Client<S>>> MakeClient(Node& node, const std::string& service,
                                              std::function<void()> on_match_changed = {}) {
  auto raw = RawClient::Make(node, service, std::string(S::kTypeName), std::move(on_match_changed));
  if (!raw) return raw.error();
  return std::make_unique<Client<S>>(std::move(raw).value());
}

template <msg::Service S>
Result<std::unique_ptr<Server<S>>> MakeServer(Node& node, const std::string& service,
                                              typename Server<S>::HandlerOfCaller handler) {
  auto on_request = [handler = std::move(handler)](const msg::RequestId& id,
                                                   std::span<const std::byte> bytes,
                                                   RawServer::Reply reply, ParticipantId caller) {
    typename S::Request request{};
    if (!internal::DecodeEnvelope(bytes, request)) return false;
    handler(
        request,
        [id, reply = std::move(reply)](const typename S::Response& response) {
          reply(internal::EncodeEnvelope(id, response));
        },
        caller);
    return true;
  };
  auto raw = RawServer::Make(node, service, std::string(S::kTypeName), std::move(on_request));
  if (!raw) return raw.error();
  return std::make_unique<Server<S>>(std::move(raw).value());
}

template <msg::Service S>
Result<std::unique_ptr<Server<S>>> MakeServer(Node& node, const std::string& service,
                                              typename Server<S>::Handler handler) {
  return MakeServer<S>(node, service,
                       typename Server<S>::HandlerOfCaller(
                           [handler = std::move(handler)](
                               const typename S::Request& request, typename Server<S>::Reply reply,
                               ParticipantId) { handler(request, std::move(reply)); }));
}

}  // namespace musher::transport
