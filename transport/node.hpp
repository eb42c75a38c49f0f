#pragma once
// A participant of the robot's domain with its loop, and the publishers, subscriptions, service
// clients and servers made from it. Topic and service names are ROS 2's, without "rt/", "rq/" or
// "rr/" and without a leading '/': "chat" is ROS 2's /chat.
//
//   auto chat = MakePublisher<msg::String>(node, "chat");
//   auto subscription = MakeSubscription<msg::String>(
//       node, "chat", [](const msg::String& m, const SampleInfo&) { ... });
//   auto server = MakeServer<msg::Trigger>(
//       node, "reset", [](const auto& request, auto reply) { ... });
//   auto client = MakeClient<msg::Trigger>(node, "reset");
//   client.value()->Call({}, Milliseconds(100), [](auto answer) { ... });
//
// Each of them returns a Result with a handle, which ends what it stands for when it is dropped.
//
// Threads: the node's loop thread only, except where EventLoop permits others. Everything made from
// a node must be dropped before the node. Several actuators of a process may share one node.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/messages/cdr.hpp"
#include "musher/transport/endpoint.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::transport {

class Node {
 public:
  virtual ~Node() = default;

  virtual EventLoop& loop() = 0;

  // The participant, as others see it in SampleInfo. Nodes of one process may share it.
  virtual ParticipantId participant() const = 0;

  // DDS topic and type names, mangled: "rt/chat", "std_msgs::msg::dds_::String_".
  virtual Result<std::unique_ptr<RawWriter>> MakeRawWriter(const std::string& topic,
                                                           const std::string& type, const Qos& qos,
                                                           WriterCallbacks callbacks) = 0;
  virtual Result<std::unique_ptr<RawReader>> MakeRawReader(const std::string& topic,
                                                           const std::string& type, const Qos& qos,
                                                           ReaderCallbacks callbacks) = 0;

  // For one rate-limited log: `handler` runs on the loop for each fault; empty: none.
  void SetOnPeerFault(std::function<void(const PeerFault&)> handler) {
    on_peer_fault_ = std::move(handler);
  }
  void ReportPeerFault(const PeerFault& fault) const {
    if (on_peer_fault_) on_peer_fault_(fault);
  }

  // The other participants that are known now; none where the transport does not know.
  virtual std::vector<PeerInfo> Peers() const { return {}; }
  // The ROS 2 nodes of that participant, "/planner_server": of several a list, "/amcl, /planner".
  // Empty: it has none, or none with the services of every node.
  virtual std::string RosNodeOf(ParticipantId /*participant*/) const { return {}; }

 private:
  std::function<void(const PeerFault&)> on_peer_fault_;
};

// What people call another participant, by what it says of itself: its user, if it is a command
// line ("alice@dog1"), its node ("/planner"), or its process ("process 4711 of dog1"); empty: it
// says nothing. Reads all of discovery: for rare events.
inline std::string NameOf(const Node& node, ParticipantId participant) {
  std::string name = node.RosNodeOf(participant);
  for (const PeerInfo& peer : node.Peers()) {
    if (peer.id != participant) continue;
    if (!peer.name.empty()) return peer.name;
    if (name.empty() && peer.pid != 0) {
      name = "process " + std::to_string(peer.pid) + " of " + peer.host;
    }
  }
  return name;
}

// Resolves a name as ROS 2 does: a relative one gets the namespace ("" or "dog1"), an absolute one
// ("/show/state") does not.
inline std::string ResolveName(std::string_view name_space, std::string_view name) {
  if (name.starts_with('/')) return std::string(name.substr(1));
  return name_space.empty() ? std::string(name) : std::string(name_space) + "/" + std::string(name);
}

// PeerFault::what.
inline constexpr std::string_view kMalformedSamples = "sends samples that do not fit the type";

template <msg::Message M>
class Publisher {
 public:
  explicit Publisher(std::unique_ptr<RawWriter> writer) : writer_(std::move(writer)) {}

  Result<> Publish(const M& message) { return writer_->Write(msg::Encode(message)); }
  int MatchedReaders() const { return writer_->MatchedReaders(); }
  // Blocks until all matched readers have all samples; for a program that then exits.
  Result<> Flush(Duration timeout) { return writer_->Flush(timeout); }

 private:
  std::unique_ptr<RawWriter> writer_;
};

// Delivers samples until it is dropped. Samples that do not decode are counted and dropped.
class Subscription {
 public:
  Subscription(std::unique_ptr<RawReader> reader, std::shared_ptr<std::uint64_t> malformed)
      : malformed_(std::move(malformed)), reader_(std::move(reader)) {}

  int MatchedWriters() const { return reader_->MatchedWriters(); }
  bool HasWriterOf(ParticipantId participant) const { return reader_->HasWriterOf(participant); }
  // Each once.
  std::vector<ParticipantId> WriterParticipants() const { return reader_->WriterParticipants(); }
  std::uint64_t malformed() const { return *malformed_; }

 private:
  std::shared_ptr<std::uint64_t> malformed_;
  std::unique_ptr<RawReader> reader_;  // last: its callbacks end before what they use
};

// Callbacks of a subscription beside its samples; both optional.
struct SubscriptionEvents {
  std::function<void(EndpointId writer)> on_writer_lost;
  std::function<void()> on_match_changed;
};

template <msg::Message M>
Result<std::unique_ptr<Publisher<M>>> MakePublisher(Node& node, const std::string& topic,
                                                    const Qos& qos = kDefaultQos,
                                                    WriterCallbacks callbacks = {}) {
  auto writer =
      node.MakeRawWriter("rt/" + topic, std::string(M::kTypeName), qos, std::move(callbacks));
  if (!writer) return writer.error();
  return std::make_unique<Publisher<M>>(std::move(writer).value());
}

// The callback owns the message and may move it.
template <msg::Message M>
Result<std::unique_ptr<Subscription>> MakeSubscription(
    Node& node, const std::string& topic, std::function<void(M&&, const SampleInfo&)> on_message,
    const Qos& qos = kDefaultQos, SubscriptionEvents events = {}) {
  auto malformed = std::make_shared<std::uint64_t>(0);
  ReaderCallbacks callbacks;
  callbacks.on_sample = [malformed, on_message = std::move(on_message), &node, topic](
                            std::span<const std::byte> bytes, const SampleInfo& info) {
    if (auto message = msg::Decode<M>(bytes)) {
      on_message(std::move(*message), info);
    } else {
      ++*malformed;
      node.ReportPeerFault({info.participant, "rt/" + topic, std::string(kMalformedSamples)});
    }
  };
  callbacks.on_writer_lost = std::move(events.on_writer_lost);
  callbacks.on_match_changed = std::move(events.on_match_changed);
  auto reader =
      node.MakeRawReader("rt/" + topic, std::string(M::kTypeName), qos, std::move(callbacks));
  if (!reader) return reader.error();
  return std::make_unique<Subscription>(std::move(reader).value(), std::move(malformed));
}

}  // namespace musher::transport
