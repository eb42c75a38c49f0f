#include "musher/view/foxglove/foxglove_server.hpp"

#include <algorithm>
#include <chrono>
#include <set>

#include "musher/view/foxglove/client.hpp"
#include "musher/view/record/type_names.hpp"

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

}  // namespace musher::view::foxglove
