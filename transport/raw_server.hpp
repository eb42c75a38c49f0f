#pragma once
// The untyped half of a service server. A reply is held until the readers of the calling
// participant are matched, so that it cannot get lost between the two halves of discovery: a
// participant has one reply reader for each of its clients, hence as many as it has request
// writers. When a client closes, its writer may be unmatched before its reader: that reader is not
// counted for another client until it is unmatched as well, or for 1 s (it may never have been
// matched). A reply that has waited for 5 s is dropped if its client has exited, or if work waits
// for it (AfterReplies()); else after 15 s. A request of a participant that is not matched (any
// more) is dropped: it could not be answered or attributed.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "musher/messages/cdr.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

class RawServer {
 public:
  // Takes an encoded reply and sends it, now or when the client's reader is matched. A second call
  // and a call after the server is dropped do nothing.
  using Reply = std::function<void(msg::Bytes)>;
  // Gets a whole request sample and its participant; returns false if it does not decode.
  using OnRequest =
      std::function<bool(const msg::RequestId&, std::span<const std::byte>, Reply, ParticipantId)>;

  // `type` is the service's, "std_srvs::srv::dds_::Trigger_".
  static Result<std::unique_ptr<RawServer>> Make(Node& node, const std::string& service,
                                                 const std::string& type, OnRequest on_request);

  std::uint64_t malformed() const { return malformed_; }
  // Whether a reply waits for the reader of the calling client.
  bool Holds() const { return !held_.empty(); }
  std::uint64_t dropped() const { return dropped_; }
  std::uint64_t unknown() const { return unknown_; }
  // Runs `work` when no reply to that participant is held or delayed: at once, or after the last
  // one is sent or dropped. It may drop the server, and does not run after that.
  void AfterReplies(ParticipantId participant, std::function<void()> work);
  // Whether a client of that participant is matched.
  bool HasClientOf(ParticipantId participant) const { return requests_->HasWriterOf(participant); }

 private:
  struct Held {
    ParticipantId participant;
    msg::Bytes reply;
    LoopHandlePtr expiry;
    std::vector<std::function<void()>> then;
  };

  // The matched endpoints of a participant.
  struct Peer {
    int writers = 0;
    int readers = 0;
    int leaving = 0;  // clients whose writer is lost and whose reader is not; below 0: vice versa
    LoopHandlePtr settled;  // resets `leaving`
  };

  RawServer(Node& node, std::string service, OnRequest on_request)
      : node_(node),
        loop_(node.loop()),
        service_(std::move(service)),
        on_request_(std::move(on_request)) {}

  void CountMalformed(ParticipantId participant);
  void TakeRequest(std::span<const std::byte> bytes, const SampleInfo& info);
  void SendOrHold(ParticipantId participant, msg::Bytes reply);
  void Hold(std::list<Held>::iterator held, Time until);
  void OnMatchChanged();
  void NoteMatches(ParticipantId participant, Peer& peer);
  bool ReachesClientsOf(ParticipantId participant) const;
  void SendHeld();
  static void Run(const std::vector<std::function<void()>>& work);
  void Send(ParticipantId participant, msg::Bytes reply);

  Node& node_;
  EventLoop& loop_;
  const std::string service_;
  OnRequest on_request_;
  std::shared_ptr<RawServer*> self_ =
      std::make_shared<RawServer*>(this);  // lets replies outlive us
  std::uint64_t malformed_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint64_t unknown_ = 0;
  std::list<Held> held_;
  std::map<ParticipantId, Peer> peers_;
  std::unique_ptr<RawWriter> replies_;
  std::unique_ptr<RawReader> requests_;
};

}  // namespace musher::transport
