#pragma once
// A Foxglove or Lichtblick client connects to the robot with no bridge: every topic whose type
// Musher knows is a channel with its definition (ros2msg) and its bytes as they are on the wire
// (CDR); services can be called, and topics published, by a client that may act.
//
// A topic is subscribed to while a client subscribes to its channel. A client that is slower than
// its topics gets the newest message of each; a status message says how many it has missed.
//
// What acts passes the guards of the page, each time:
//   login     without one, or after its end, only the services that change nothing are called
//   machine   nothing is called or published that another machine than the one that is followed
//             would receive, or while another one may be meant; a pause and a cancellation are sent
//             all the same, and only the reply of that machine counts
//   age       nothing that may raise or move the robot is called or published whose client has last
//             answered a ping of more than 5 s ago: a wifi that was lost delivers it half a minute
//             later. Each second a ping has the time of this host, and what a client sends after
//             its answer is not older than that
// Topics of the machine itself (<namespace>/musher/...) cannot be published, and the commands of a
// controller to its actuators cannot be called.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/lifecycle/machine/machine_identity.hpp"
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

  struct Leader {
    MachineIdentity machine;
    transport::ParticipantId participant;  // of its controller
  };
  using Participants = std::vector<transport::ParticipantId>;
  using WhyNot = std::optional<Error>;
  // All are required.
  struct Guards {
    // The machine that is followed, while its controller leads.
    std::function<std::optional<Leader>()> leader;
    // Why another machine may be meant.
    std::function<WhyNot()> why_not_meant;
    // Why nothing is published for the readers of this topic, "/chat".
    std::function<WhyNot(const std::string& topic)> why_not_published;
    // Calls `then` once, later: why nothing is sent to these servers, which are of that actuator.
    std::function<void(const std::string& actuator, std::function<Participants()> servers,
                       std::function<void(WhyNot)> then)>
        check_servers;
    // Milliseconds since the boot of this host, also while it was suspended.
    std::function<std::int64_t()> uptime_ms;
    // Why a request is too late whose client has last been sent that uptime.
    std::function<WhyNot(std::int64_t seen_ms)> why_late;
    // Whether a switch to that state, of that actuator or of the machine (""), raises nothing.
    std::function<bool(const std::string& state, const std::string& actuator)> only_lowers;
    // Whether the reply of that server counts, of all that have received the request.
    std::function<bool(transport::ParticipantId server, const Participants& servers)> counts;
  };
  struct Options {
    std::string name;  // of the robot, as the client shows it
    std::string name_space;
    Guards guards;
  };

  // The node and the table must outlive it.
  FoxgloveServer(transport::Node& node, const TopicTable& table, Options options);
  ~FoxgloveServer();
  FoxgloveServer(const FoxgloveServer&) = delete;
  FoxgloveServer& operator=(const FoxgloveServer&) = delete;

  // `may_act`: whether its login lives; called each time that it acts.
  http::WebSocketHandlers OnWebSocket(std::shared_ptr<http::WebSocket> socket,
                                      std::function<bool()> may_act);
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
  // A call that its guards permit, with the numbers of its client, service and call.
  struct PermittedCall {
    std::uint64_t client = 0;
    std::uint32_t service = 0;
    std::uint32_t call = 0;
    msg::Bytes fields;  // CDR without its header
  };
  OpenService* FindService(std::uint32_t id);
  // Whether it is a service of the controller in the namespace of this server.
  bool IsOfController(const OpenService& service) const;
  WhyNot WhyNotCalled(const Client& client, const OpenService& service,
                      const ServiceCall& call) const;
  WhyNot WhyNotPublished(const Client& client, const std::string& topic, bool never_late) const;
  void PingAll();
  void Send(const PermittedCall& call);
  void Fail(const PermittedCall& call, const std::string& why);
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
  transport::LoopHandlePtr every_second_;  // last: its callback uses the rest
};

}  // namespace musher::view::foxglove
