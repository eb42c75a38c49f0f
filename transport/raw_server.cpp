#include "musher/transport/raw_server.hpp"

#include <algorithm>
#include <iterator>

#include "musher/transport/service_names.hpp"

namespace musher::transport {

namespace {

constexpr Duration kLongestHold = std::chrono::seconds(5);
// How long a reply is held for a client that is half discovered. On a bad network discovery takes
// 10 s.
constexpr Duration kLongestDiscovery = std::chrono::seconds(15);
// The writer and the reader of a closed client are unmatched within this time of each other.
constexpr Duration kUnmatchInterval = std::chrono::seconds(1);

}  // namespace

Result<std::unique_ptr<RawServer>> RawServer::Make(Node& node, const std::string& service,
                                                   const std::string& type, OnRequest on_request) {
  std::unique_ptr<RawServer> server(new RawServer(node, service, std::move(on_request)));
  RawServer* self = server.get();

  // The writer first, so that it exists when the first request arrives.
  WriterCallbacks writer_callbacks;
  writer_callbacks.on_match_changed = [self] { self->OnMatchChanged(); };
  auto replies = node.MakeRawWriter(ReplyTopic(service), ResponseType(type), kDefaultQos,
                                    std::move(writer_callbacks));
  if (!replies) return replies.error();
  server->replies_ = std::move(replies).value();

  ReaderCallbacks reader_callbacks;
  reader_callbacks.on_sample = [self](std::span<const std::byte> bytes, const SampleInfo& info) {
    self->TakeRequest(bytes, info);
  };
  reader_callbacks.on_match_changed = [self] { self->OnMatchChanged(); };
  auto requests = node.MakeRawReader(RequestTopic(service), RequestType(type), kServiceReaderQos,
                                     std::move(reader_callbacks));
  if (!requests) return requests.error();
  server->requests_ = std::move(requests).value();
  return server;
}

void RawServer::SendOrHold(ParticipantId participant, msg::Bytes reply) {
  loop_.CheckThread();
  if (ReachesClientsOf(participant)) {
    Send(participant, std::move(reply));
    return;
  }
  held_.push_back({participant, std::move(reply), nullptr, {}});
  Hold(std::prev(held_.end()), loop_.Now() + kLongestDiscovery);
}

// If work waits for a held reply, the reply is dropped after kLongestHold, even if its client still
// exists.
void RawServer::Hold(std::list<Held>::iterator held, Time until) {
  held->expiry = loop_.At(std::min(loop_.Now() + kLongestHold, until), [this, held, until] {
    const bool there = requests_->HasWriterOf(held->participant);
    if (there && held->then.empty() && loop_.Now() < until) return Hold(held, until);
    ++dropped_;
    const auto then = std::move(held->then);
    held_.erase(held);
    Run(then);
  });
}

void RawServer::AfterReplies(ParticipantId participant, std::function<void()> work) {
  loop_.CheckThread();
  const auto last = std::find_if(held_.rbegin(), held_.rend(),
                                 [&](const Held& held) { return held.participant == participant; });
  if (last == held_.rend()) return replies_->AfterWrites(std::move(work));
  last->then.emplace_back([self = std::weak_ptr(self_), work = std::move(work)] {
    if (const auto server = self.lock()) (*server)->replies_->AfterWrites(work);
  });
}

// Last: they may drop the server.
void RawServer::Run(const std::vector<std::function<void()>>& work) {
  for (const auto& each : work) each();
}

void RawServer::TakeRequest(std::span<const std::byte> bytes, const SampleInfo& info) {
  if (info.participant == 0) {
    ++unknown_;
    return;
  }
  msg::CdrReader reader(bytes);
  msg::RequestId id;
  reader.Get(id);
  if (!reader.ok()) return CountMalformed(info.participant);
  Reply reply = [weak = std::weak_ptr(self_), participant = info.participant,
                 open = std::make_shared<bool>(true)](msg::Bytes encoded) {
    const auto self = weak.lock();
    if (self && std::exchange(*open, false)) (*self)->SendOrHold(participant, std::move(encoded));
  };
  // The handler may drop the server, so no member is used after a request that decoded.
  if (!on_request_(id, bytes, std::move(reply), info.participant)) CountMalformed(info.participant);
}

void RawServer::CountMalformed(ParticipantId participant) {
  ++malformed_;
  node_.ReportPeerFault({participant, RequestTopic(service_), std::string(kMalformedSamples)});
}

void RawServer::OnMatchChanged() {
  if (!requests_) return;  // no request can have arrived yet
  for (const ParticipantId participant : requests_->WriterParticipants())
    peers_.try_emplace(participant);
  for (auto& [participant, peer] : peers_) NoteMatches(participant, peer);
  std::erase_if(peers_, [](const auto& entry) {
    return entry.second.writers == 0 && entry.second.readers == 0;
  });
  SendHeld();
}

void RawServer::NoteMatches(ParticipantId participant, Peer& peer) {
  const int writers = requests_->WritersOf(participant);
  const int readers = replies_->ReadersOf(participant);
  const int lost_writers = std::max(peer.writers - writers, 0);
  const int lost_readers = std::max(peer.readers - readers, 0);
  peer.writers = writers;
  peer.readers = readers;
  if (lost_writers == lost_readers) return;
  peer.leaving += lost_writers - lost_readers;
  peer.settled = nullptr;
  if (peer.leaving == 0) return;
  peer.settled = loop_.At(loop_.Now() + kUnmatchInterval, [this, &peer] {
    peer.leaving = 0;
    SendHeld();
  });
}

bool RawServer::ReachesClientsOf(ParticipantId participant) const {
  const auto peer = peers_.find(participant);
  const int leaving = peer == peers_.end() ? 0 : std::max(peer->second.leaving, 0);
  const int readers = replies_->ReadersOf(participant) - leaving;
  return readers >= std::max(requests_->WritersOf(participant), 1);
}

void RawServer::SendHeld() {
  std::vector<std::function<void()>> then;
  for (auto held = held_.begin(); held != held_.end();) {
    const auto next = std::next(held);
    if (ReachesClientsOf(held->participant)) {
      Send(held->participant, std::move(held->reply));
      std::ranges::move(held->then, std::back_inserter(then));
      held_.erase(held);
    }
    held = next;
  }
  Run(then);
}

void RawServer::Send(ParticipantId participant, msg::Bytes reply) {
  if (!replies_->WriteFor(participant, std::move(reply))) ++dropped_;
}

}  // namespace musher::transport
