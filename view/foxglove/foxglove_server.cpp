#include "musher/view/foxglove/foxglove_server.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <set>

#include "musher/view/foxglove/client.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::view::foxglove {
namespace {

std::uint64_t WallNanoseconds() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(Duration(now).count());
}

// "musher/set_state" of the topic "rq/musher/set_stateRequest"; "" for any other.
std::string ServiceOf(const std::string& topic) {
  constexpr std::string_view kPrefix = "rq/";
  constexpr std::string_view kSuffix = "Request";
  if (!topic.starts_with(kPrefix) || !topic.ends_with(kSuffix)) return "";
  return topic.substr(kPrefix.size(), topic.size() - kPrefix.size() - kSuffix.size());
}

// "musher_msgs::srv::dds_::SetState_" of "musher_msgs::srv::dds_::SetState_Request_".
std::string ServiceType(const std::string& request_type) {
  constexpr std::string_view kEnd = "Request_";
  if (!request_type.ends_with(kEnd)) return "";
  return request_type.substr(0, request_type.size() - kEnd.size());
}

constexpr std::size_t kHeader = 4;     // of CDR
constexpr std::size_t kEnvelope = 16;  // a client's id and a sequence number
constexpr std::size_t kMostPublished = 64;

// Services that change nothing.
constexpr std::array<std::string_view, 8> kReading = {
    "musher_msgs::srv::dds_::GetStatus_",       "musher_msgs::srv::dds_::GetPlan_",
    "musher_msgs::srv::dds_::GetSwitch_",       "musher_msgs::srv::dds_::GetHistory_",
    "musher_msgs::srv::dds_::GetCapabilities_", "musher_msgs::srv::dds_::GetBehavior_",
    "musher_msgs::srv::dds_::GetTree_",         "lifecycle_msgs::srv::dds_::GetState_"};

constexpr const char* kNeedsLogin =
    "needs a login: connect to ws://.../?token=TOKEN, with the token of musher-view's token file";

bool IsLittleEndianCdr(std::span<const std::byte> bytes) {
  return bytes.size() >= kHeader && bytes[0] == std::byte{0} && bytes[1] == std::byte{1};
}

// "std_msgs/String" and "std_msgs/msg/String" as on DDS; "" if it is no such name.
std::string TypeOf(const std::string& schema) {
  const std::size_t slash = schema.find('/');
  if (slash == std::string::npos) return "";
  const bool is_short = schema.find('/', slash + 1) == std::string::npos;
  return DdsType(is_short ? schema.substr(0, slash) + "/msg" + schema.substr(slash) : schema);
}

// Whether it is a topic name of ROS 2: "/", then parts of letters, digits and '_'.
bool IsTopicName(const std::string& name) {
  return name.size() > 1 && name.size() < 256 && name.front() == '/' && name.back() != '/' &&
         name.find("//") == std::string::npos &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '/'; });
}

}  // namespace

FoxgloveServer::FoxgloveServer(transport::Node& node, const TopicTable& table, Options options)
    : node_(node),
      table_(table),
      options_(std::move(options)),
      session_(std::to_string(WallNanoseconds())) {}

FoxgloveServer::~FoxgloveServer() = default;

http::WebSocketHandlers FoxgloveServer::OnWebSocket(std::shared_ptr<http::WebSocket> socket,
                                                    bool may_act) {
  const std::uint64_t id = next_client_++;
  auto& client = clients_[id];
  client = std::make_unique<Client>(id, std::move(socket), may_act);
  client->Send(ServerInfo(options_.name, session_));
  if (const auto channels = Channels(); !channels.empty()) client->Send(Advertise(channels));
  if (const auto services = Services(); !services.empty()) {
    client->Send(AdvertiseServices(services));
  }
  http::WebSocketHandlers handlers;
  handlers.on_message = [this, client = client.get()](const std::string& message, bool binary) {
    On(*client, binary ? ReadBinary(std::as_bytes(std::span(message))) : ReadText(message));
  };
  handlers.on_drained = [client = client.get()] { client->SendWaiting(); };
  handlers.on_closed = [this, id] { OnClosed(id); };
  return handlers;
}

void FoxgloveServer::OnClosed(std::uint64_t id) {
  clients_.erase(id);
  OpenReaders();
}

void FoxgloveServer::SendAll(const std::string& text) {
  for (const auto& [id, client] : clients_) client->Send(text);
}

Channel FoxgloveServer::Described(const TopicKey& key, const OpenChannel& channel) {
  return {channel.id, key.first, std::string(channel.definition->ros_type),
          channel.definition->text};
}

std::vector<Channel> FoxgloveServer::Channels() const {
  std::vector<Channel> all;
  for (const auto& [key, channel] : channels_) all.push_back(Described(key, channel));
  return all;
}

void FoxgloveServer::OnTopicsChanged() {
  std::set<TopicKey> there;
  std::vector<Channel> found;
  for (const ListedTopic& topic : table_.List()) {
    const msg::MessageDefinition* definition = msg::FindDefinition(topic.dds_type);
    if (topic.publishers == 0 || definition == nullptr) continue;
    const TopicKey key{topic.name, topic.dds_type};
    there.insert(key);
    const auto [channel, is_new] = channels_.try_emplace(key);
    if (!is_new) continue;
    channel->second.id = next_id_++;
    channel->second.definition = definition;
    found.push_back(Described(key, channel->second));
  }
  std::vector<std::uint32_t> lost;
  for (const auto& [key, channel] : channels_) {
    if (!there.contains(key)) lost.push_back(channel.id);
  }
  if (!lost.empty()) {
    for (const auto& [id, client] : clients_) client->Forget(lost);
    std::erase_if(channels_, [&there](const auto& each) { return !there.contains(each.first); });
    SendAll(Unadvertise(lost));
  }
  if (!found.empty()) SendAll(Advertise(found));
  OpenReaders();
}

std::pair<const FoxgloveServer::TopicKey, FoxgloveServer::OpenChannel>* FoxgloveServer::ChannelOf(
    std::uint32_t id) {
  const auto found = std::find_if(channels_.begin(), channels_.end(),
                                  [id](const auto& channel) { return channel.second.id == id; });
  return found == channels_.end() ? nullptr : &*found;
}

// Subscribes to what clients want, with a QoS that matches the topic's writers as they are now.
void FoxgloveServer::OpenReaders() {
  for (auto& [key, channel] : channels_) {
    const bool wanted =
        std::any_of(clients_.begin(), clients_.end(),
                    [id = channel.id](const auto& client) { return client.second->Wants(id); });
    if (!wanted) {
      channel.reader.reset();
      channel.latched.reset();
      continue;
    }
    const auto source = table_.SourceOf(key.first);
    if (!source || (channel.reader && channel.source == *source)) continue;
    channel.source = *source;
    channel.reader.reset();
    transport::ReaderCallbacks callbacks;
    callbacks.on_sample = [this, &channel = channel](std::span<const std::byte> bytes,
                                                     const transport::SampleInfo&) {
      if (channel.source.qos.durability == transport::Qos::Durability::kTransientLocal) {
        channel.latched = std::make_shared<const msg::Bytes>(bytes.begin(), bytes.end());
      }
      OnSample(channel, bytes);
    };
    auto reader =
        node_.MakeRawReader("rt" + key.first, key.second, source->qos, std::move(callbacks));
    if (reader) {
      channel.reader = std::move(reader).value();
    } else {
      SendAll(Status(StatusLevel::kError, key.first + ": " + reader.error().message));
    }
  }
}

void FoxgloveServer::OnSample(const OpenChannel& channel, std::span<const std::byte> bytes) {
  const std::uint64_t now = WallNanoseconds();
  for (const auto& [id, client] : clients_) client->SendSample(channel.id, now, bytes);
}

bool FoxgloveServer::OnFound(const transport::DiscoveredEndpoint& endpoint) {
  const std::string name = endpoint.writer ? "" : ServiceOf(endpoint.topic);
  const std::string type = ServiceType(endpoint.type);
  if (name.empty() || msg::FindDefinition(endpoint.type) == nullptr ||
      msg::FindDefinition(type + "Response_") == nullptr) {
    return false;
  }
  servers_[endpoint.id] = {name, type};
  return true;
}

bool FoxgloveServer::OnLost(transport::EndpointId id) {
  return servers_.erase(id) > 0;
}

Service FoxgloveServer::Described(const OpenService& service) {
  std::string type = RosType(service.type);
  return {service.id, "/" + service.name, std::move(type),
          msg::FindDefinition(service.type + "Request_")->text,
          msg::FindDefinition(service.type + "Response_")->text};
}

std::vector<Service> FoxgloveServer::Services() const {
  std::vector<Service> all;
  for (const auto& [name, service] : services_) all.push_back(Described(service));
  return all;
}

void FoxgloveServer::OnServicesChanged() {
  std::map<std::string, std::string> there;
  for (const auto& [id, server] : servers_) there.insert(server);
  std::vector<std::uint32_t> lost;
  std::erase_if(services_, [&](const auto& service) {
    const auto now = there.find(service.first);
    const bool gone = now == there.end() || now->second != service.second.type;
    if (gone) lost.push_back(service.second.id);
    return gone;
  });
  std::vector<Service> found;
  for (const auto& [name, type] : there) {
    const auto [service, is_new] = services_.try_emplace(name);
    if (!is_new) continue;
    service->second.id = next_id_++;
    service->second.name = name;
    service->second.type = type;
    found.push_back(Described(service->second));
  }
  if (!lost.empty()) SendAll(UnadvertiseServices(lost));
  if (!found.empty()) SendAll(AdvertiseServices(found));
}

// --- the requests of clients ---

void FoxgloveServer::On(Client& client, const Result<FromClient>& message) {
  if (!message) return client.Send(Status(StatusLevel::kError, message.error().message));
  std::visit(
      [&](const auto& one) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(one)>, Ignored>) On(client, one);
      },
      message.value());
}

void FoxgloveServer::On(Client& client, const Subscribe& subscribe) {
  for (const Subscribe::One& one : subscribe.subscriptions) {
    auto* const channel = ChannelOf(one.channel);
    if (channel == nullptr) {
      client.Send(Status(StatusLevel::kWarning,
                         "There is no channel " + std::to_string(one.channel) + " any more."));
      continue;
    }
    client.subscriptions[one.id] = one.channel;
    // The reader of an earlier client has received what is latched.
    if (channel->second.reader && channel->second.latched) {
      const auto now = std::chrono::system_clock::now().time_since_epoch();
      client.SendBinary(MessageData(one.id, static_cast<std::uint64_t>(Duration(now).count()),
                                    *channel->second.latched));
    }
  }
  OpenReaders();
}

void FoxgloveServer::On(Client& client, const Unsubscribe& unsubscribe) {
  for (const std::uint32_t id : unsubscribe.subscriptions) {
    client.subscriptions.erase(id);
    client.waiting.erase(id);
  }
  OpenReaders();
}

void FoxgloveServer::On(Client& client, const ClientAdvertise& advertise) {
  const std::string machine = "/" + transport::ResolveName(options_.name_space, "musher/");
  for (const ClientAdvertise::Channel& channel : advertise.channels) {
    const auto refuse = [&](const std::string& why) {
      client.Send(Status(StatusLevel::kError, channel.topic + " is not published: " + why));
    };
    const std::string type = TypeOf(channel.schema);
    if (!client.may_act) {
      refuse(std::string("publishing ") + kNeedsLogin);
    } else if (channel.encoding != "cdr") {
      refuse("its encoding is '" + channel.encoding + "'; known is cdr");
    } else if (type.empty() || msg::FindDefinition(type) == nullptr) {
      refuse("Musher does not know the type '" + channel.schema + "'");
    } else if (!IsTopicName(channel.topic)) {
      refuse("a topic is '/' and parts of letters, digits and '_'");
    } else if (channel.topic.starts_with(machine)) {
      refuse("topics below " + machine + " are the machine's own");
    } else if (client.published.size() >= kMostPublished) {
      refuse("a client publishes at most " + std::to_string(kMostPublished) + " topics");
    } else {
      auto writer = node_.MakeRawWriter("rt" + channel.topic, type, transport::kDefaultQos, {});
      if (!writer) {
        refuse(writer.error().message);
        continue;
      }
      client.published[channel.id] = {channel.topic, std::move(writer).value()};
    }
  }
}

void FoxgloveServer::On(Client& client, const ClientUnadvertise& unadvertise) {
  for (const std::uint32_t id : unadvertise.channels) client.published.erase(id);
}

void FoxgloveServer::On(Client& client, const ClientMessage& message) {
  const auto found = client.published.find(message.channel);
  if (found == client.published.end()) {
    return client.Send(Status(StatusLevel::kError, "A message of a channel that is not published.",
                              "unknown channel"));
  }
  if (!IsLittleEndianCdr(message.data)) {
    return client.Send(Status(StatusLevel::kError,
                              found->second.topic + ": a message has to be little-endian CDR"));
  }
  const auto written = found->second.writer->Write({message.data.begin(), message.data.end()});
  if (!written) {
    client.Send(Status(StatusLevel::kError, found->second.topic + ": " + written.error().message));
  }
}

void FoxgloveServer::On(Client& client, const ServiceCall& call) {
  const auto fail = [&](const std::string& why) {
    client.Send(ServiceCallFailure(call.service, call.call, why));
  };
  const auto found = std::find_if(services_.begin(), services_.end(), [&](const auto& service) {
    return service.second.id == call.service;
  });
  if (found == services_.end()) return fail("the service is not there any more");
  OpenService& service = found->second;
  const bool reads = std::find(kReading.begin(), kReading.end(), service.type) != kReading.end();
  if (!reads && !client.may_act) return fail("calling /" + service.name + " " + kNeedsLogin);
  if (call.encoding != "cdr" || !IsLittleEndianCdr(call.data)) {
    return fail("a request has to be little-endian CDR");
  }
  if (!service.client) {
    auto made = transport::RawClient::Make(node_, service.name, service.type, {});
    if (!made) return fail(made.error().message);
    service.client = std::move(made).value();
  }
  const msg::RequestId id = service.client->NextId();
  // The id's 16 bytes leave the alignment of what follows as it is.
  msg::Bytes request = msg::Encode(id);
  request.insert(request.end(), call.data.begin() + kHeader, call.data.end());
  service.client->Call(id, std::move(request), kCallTime,
                       [this, number = client.id, service = call.service,
                        call = call.call](const Result<std::span<const std::byte>>& reply) {
                         OnReply(number, service, call, reply);
                       });
}

void FoxgloveServer::OnReply(std::uint64_t client, std::uint32_t service, std::uint32_t call,
                             const Result<std::span<const std::byte>>& reply) {
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  if (!reply || reply.value().size() < kHeader + kEnvelope) {
    return found->second->Send(ServiceCallFailure(
        service, call, reply ? "the reply is malformed" : reply.error().message));
  }
  found->second->SendBinary(ServiceCallResponse(service, call, reply.value().first(kHeader),
                                                reply.value().subspan(kHeader + kEnvelope)));
}

}  // namespace musher::view::foxglove
