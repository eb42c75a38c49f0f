#include "musher/transport/raw_client.hpp"

#include <algorithm>

#include "musher/transport/service_names.hpp"

namespace musher::transport {

Result<std::unique_ptr<RawClient>> RawClient::Make(Node& node, const std::string& service,
                                                   const std::string& type,
                                                   std::function<void()> on_match_changed) {
  std::unique_ptr<RawClient> client(new RawClient(node, service, std::move(on_match_changed)));
  RawClient* self = client.get();

  // The reader first: a server that discovers the writer has then discovered the reader, too.
  ReaderCallbacks reader_callbacks;
  reader_callbacks.on_sample = [self](std::span<const std::byte> bytes, const SampleInfo& info) {
    self->TakeReply(bytes, info.participant);
  };
  reader_callbacks.on_match_changed = [self] { self->OnMatchChanged(); };
  auto replies = node.MakeRawReader(ReplyTopic(service), ResponseType(type), kServiceReaderQos,
                                    std::move(reader_callbacks));
  if (!replies) return replies.error();
  client->replies_ = std::move(replies).value();

  WriterCallbacks writer_callbacks;
  writer_callbacks.on_match_changed = [self] { self->OnMatchChanged(); };
  auto requests = node.MakeRawWriter(RequestTopic(service), RequestType(type), kDefaultQos,
                                     std::move(writer_callbacks));
  if (!requests) return requests.error();
  client->requests_ = std::move(requests).value();
  return client;
}

std::vector<ParticipantId> RawClient::Servers() const {
  if (!requests_) return {};
  std::vector<ParticipantId> servers = replies_->WriterParticipants();
  std::erase_if(servers, [this](ParticipantId server) { return !requests_->HasReaderOf(server); });
  return servers;
}

msg::RequestId RawClient::NextId() {
  const msg::RequestId id = PeekId();
  ++next_sequence_;
  return id;
}

msg::RequestId RawClient::PeekId() const {
  loop_.CheckThread();
  return {requests_->UniqueId(), next_sequence_};
}

void RawClient::Call(const msg::RequestId& id, msg::Bytes request, Duration timeout,
                     OnReply on_reply, ParticipantId server, Counts counts) {
  const std::int64_t sequence = id.sequence;
  const Deadline deadline(loop_, timeout);
  PendingCall& call =
      calls_
          .insert_or_assign(
              sequence, PendingCall{std::move(request), std::move(on_reply), server,
                                    std::move(counts), deadline, EndAt(deadline.at(), sequence)})
          .first->second;
  if (Reaches(server)) Send(sequence, call);
}

LoopHandlePtr RawClient::EndAt(Time when, std::int64_t sequence) {
  return loop_.At(when, [this, sequence] {
    const bool sent = calls_.at(sequence).unsent.empty();
    End(sequence, Error{kCodeTimeout, service_ + (sent ? ": no reply in time"
                                                       : ": no server available in time")});
  });
}

bool RawClient::Reaches(ParticipantId server) const {
  const std::vector<ParticipantId> servers = Servers();
  return server == 0 ? !servers.empty() : std::ranges::count(servers, server) != 0;
}

void RawClient::OnMatchChanged() {
  for (auto& [sequence, call] : calls_) {
    if (!Reaches(call.server)) continue;
    if (call.unsent.empty()) {
      SendToNewServers(call);
    } else if (call.deadline.IsOver()) {
      call.end = EndAt(loop_.Now(), sequence);
    } else {
      Send(sequence, call);
    }
  }
  if (on_match_changed_) on_match_changed_();
}

// A server that has it already gets the request with the same id once more.
void RawClient::SendToNewServers(PendingCall& call) {
  if (call.for_all.empty() || call.deadline.IsOver()) return;
  const std::vector<ParticipantId> servers = Servers();
  const bool all = std::ranges::all_of(servers, [&call](ParticipantId server) {
    return std::ranges::count(call.sent_to, server) != 0;
  });
  if (!all && !requests_->Write(call.for_all)) {  // with the next change it is tried again
    std::erase_if(call.sent_to, [&servers](ParticipantId server) {
      return std::ranges::count(servers, server) == 0;
    });
    return;
  }
  call.sent_to = servers;
}

void RawClient::Send(std::int64_t sequence, PendingCall& call) {
  if (call.counts) call.for_all = call.unsent;
  call.sent_to = Servers();
  const Result<> written = requests_->Write(std::exchange(call.unsent, {}));
  if (written) return;
  call.end =
      loop_.At(loop_.Now(), [this, sequence, error = written.error()] { End(sequence, error); });
}

void RawClient::TakeReply(std::span<const std::byte> bytes, ParticipantId server) {
  msg::CdrReader reader(bytes);
  msg::RequestId id;
  reader.Get(id);
  if (!reader.ok() || !requests_ || id.client != requests_->UniqueId()) return;
  const auto call = calls_.find(id.sequence);
  if (call == calls_.end()) return;
  const bool of_another = call->second.server != 0 && server != 0 && call->second.server != server;
  if (of_another || (call->second.counts && !call->second.counts(server, bytes))) return;
  End(id.sequence, bytes);
}

void RawClient::End(std::int64_t sequence, const Result<std::span<const std::byte>>& outcome) {
  auto call = calls_.extract(sequence);  // a second or late reply finds no call
  if (call.empty()) return;
  call.mapped().on_reply(outcome);  // last: it may drop the client
}

}  // namespace musher::transport
