#pragma once
// A Foxglove or Lichtblick client connects to the robot with no bridge: every topic whose type
// Musher knows is a channel with its definition (ros2msg) and its bytes as they are on the wire
// (CDR); services can be called, and topics published, by a client that may act.
//
// A topic is subscribed to while a client subscribes to its channel. A client that is slower than
// its topics gets the newest message of each; a status message says how many it has missed.
//
// Without a login only the services that change nothing are called. Topics of the machine itself
// (<namespace>/musher/...) cannot be published.
//
// Threads: loop thread only.

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "musher/messages/definitions.hpp"
#include "musher/transport/dds/topic_watch.hpp"
#include "musher/transport/raw_client.hpp"
#include "musher/view/foxglove/protocol.hpp"
#include "musher/view/http/server.hpp"
#include "musher/view/topics/topic_table.hpp"

namespace musher::view::foxglove {

class FoxgloveServer {
 public:
  static constexpr Duration kCallTime = std::chrono::seconds(60);
  // With more in its connection's queue only the newest message of a subscription waits.
  static constexpr std::size_t kMostQueued = std::size_t{1} << 20;

  struct Options {
    std::string name;  // of the robot, as the client shows it
    std::string name_space;
  };

  // The node and the table must outlive it.
  FoxgloveServer(transport::Node& node, const TopicTable& table, Options options);
  ~FoxgloveServer();
  FoxgloveServer(const FoxgloveServer&) = delete;
  FoxgloveServer& operator=(const FoxgloveServer&) = delete;

  http::WebSocketHandlers OnWebSocket(std::shared_ptr<http::WebSocket> socket, bool may_act);
  std::size_t clients() const { return clients_.size(); }

  // The table has changed.
  void OnTopicsChanged();
  // What discovery finds, for services; whether the list of services has changed.
  bool OnFound(const transport::DiscoveredEndpoint& endpoint);
  bool OnLost(transport::EndpointId id);
  void OnServicesChanged();

 private:
  struct Client;
  using TopicKey = std::pair<std::string, std::string>;  // "/chat", type on DDS
  struct OpenChannel {
    std::uint32_t id = 0;
    const msg::MessageDefinition* definition = nullptr;
    TopicTable::Source source;  // of the reader
    std::shared_ptr<const msg::Bytes> latched;
    std::unique_ptr<transport::RawReader> reader;  // while a client subscribes
  };
  struct OpenService {
    std::uint32_t id = 0;
    std::string name;                              // "musher/set_state"
    std::string type;                              // "musher_msgs::srv::dds_::SetState_"
    std::unique_ptr<transport::RawClient> client;  // from the first call on
  };

  std::vector<Channel> Channels() const;
  std::vector<Service> Services() const;
  static Service Described(const OpenService& service);
  static Channel Described(const TopicKey& key, const OpenChannel& channel);
  std::pair<const TopicKey, OpenChannel>* ChannelOf(std::uint32_t id);

  void On(Client& client, const Result<FromClient>& message);
  void On(Client& client, const Subscribe& subscribe);
  void On(Client& client, const Unsubscribe& unsubscribe);
  void On(Client& client, const ClientAdvertise& advertise);
  void On(Client& client, const ClientUnadvertise& unadvertise);
  void On(Client& client, const ClientMessage& message);
  void On(Client& client, const ServiceCall& call);
  void OnReply(std::uint64_t client, std::uint32_t service, std::uint32_t call,
               const Result<std::span<const std::byte>>& reply);
  void OnSample(const OpenChannel& channel, std::span<const std::byte> bytes);
  void OnClosed(std::uint64_t id);
  void OpenReaders();
  void SendAll(const std::string& text);

  transport::Node& node_;
  const TopicTable& table_;
  const Options options_;
  const std::string session_;
  std::uint32_t next_id_ = 1;
  std::uint64_t next_client_ = 1;
  std::map<TopicKey, OpenChannel> channels_;
  std::map<transport::EndpointId, std::pair<std::string, std::string>> servers_;  // name and type
  std::map<std::string, OpenService> services_;                                   // by name
  std::map<std::uint64_t, std::unique_ptr<Client>> clients_;
};

}  // namespace musher::view::foxglove
