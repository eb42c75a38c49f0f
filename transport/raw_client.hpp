#pragma once
// The untyped half of a service client: numbers requests, holds them until a server is matched,
// finds the call of each reply, and ends every call by its deadline.
//
//   called --server matched--> sent --reply--> ended with the reply
//      \                        \---deadline-> ended with kCodeTimeout
//       \---write refused or deadline--------> ended with the reason
//
// Nothing is sent after its deadline, also where the process was stopped or the computer suspended
// until then.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "musher/messages/cdr.hpp"
#include "musher/transport/deadline.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

class RawClient {
 public:
  // The bytes of the whole sample including the request id; valid during the callback only.
  using OnReply = std::function<void(Result<std::span<const std::byte>>)>;
  // Whether this reply of that server ends a call; empty: each does.
  using Counts = std::function<bool(ParticipantId server, std::span<const std::byte> reply)>;

  // `type` is the service's, "std_srvs::srv::dds_::Trigger_".
  static Result<std::unique_ptr<RawClient>> Make(Node& node, const std::string& service,
                                                 const std::string& type,
                                                 std::function<void()> on_match_changed);

  bool Ready() const { return !Servers().empty(); }

  // The participants whose server is matched in both directions.
  std::vector<ParticipantId> Servers() const;

  // The id for encoding the next request.
  msg::RequestId NextId();
  // The id that NextId() will return.
  msg::RequestId PeekId() const;

  // Takes the encoded request with `id`; see Client::Call() for how it ends, and for `server`.
  void Call(const msg::RequestId& id, msg::Bytes request, Duration timeout, OnReply on_reply,
            ParticipantId server = 0, Counts counts = {});

  // Forgets a call: its `on_reply` does not run.
  void Drop(std::int64_t sequence) { calls_.erase(sequence); }

 private:
  struct PendingCall {
    msg::Bytes unsent;  // empty once it is sent
    OnReply on_reply;
    ParticipantId server = 0;
    Counts counts;
    Deadline deadline;
    LoopHandlePtr end;  // ends the call at its deadline, or at once if it cannot be sent
    // The sent request, for servers that match later: a call with `counts` is for every server.
    msg::Bytes for_all = {};
    std::vector<ParticipantId> sent_to = {};
  };

  RawClient(Node& node, std::string service, std::function<void()> on_match_changed)
      : loop_(node.loop()),
        service_(std::move(service)),
        on_match_changed_(std::move(on_match_changed)) {}

  LoopHandlePtr EndAt(Time when, std::int64_t sequence);
  void OnMatchChanged();
  void Send(std::int64_t sequence, PendingCall& call);
  void SendToNewServers(PendingCall& call);
  bool Reaches(ParticipantId server) const;
  void TakeReply(std::span<const std::byte> bytes, ParticipantId server);
  void End(std::int64_t sequence, const Result<std::span<const std::byte>>& outcome);

  EventLoop& loop_;
  std::string service_;
  std::function<void()> on_match_changed_;
  std::int64_t next_sequence_ = 1;
  std::map<std::int64_t, PendingCall> calls_;
  std::unique_ptr<RawReader> replies_;
  std::unique_ptr<RawWriter> requests_;
};

}  // namespace musher::transport
