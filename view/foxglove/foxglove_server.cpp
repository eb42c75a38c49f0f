#include "musher/view/foxglove/foxglove_server.hpp"

#include <algorithm>
#include <chrono>
#include <set>

#include "musher/messages/action_msgs/cancel_goal.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/transport/service.hpp"
#include "musher/view/foxglove/call_guard.hpp"
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

constexpr const char* kNeedsLogin =
    "needs a login: connect to ws://.../?token=TOKEN, with the token of musher-view's token file";

// "dog" of "dog/pause_skill" and of "dog/skill_execution/_action/send_goal".
std::string ActuatorOf(const std::string& service) {
  const std::string name = service.substr(0, service.find("/_action/"));
  return name.substr(0, name.rfind('/'));
}

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

// With an id that says nothing.
msg::Bytes RequestBytes(const ServiceCall& call) {
  msg::Bytes request = msg::Encode(msg::RequestId{});
  request.insert(request.end(), call.data.begin() + kHeader, call.data.end());
  return request;
}

// Of the replies of an action's servers to the cancellation of a goal, which at most one of them
// runs: that of this one. That it is not known counts once all of them have replied so.
transport::RawClient::Counts CountsOfCancel(std::function<FoxgloveServer::Participants()> servers) {
  return [servers = std::move(servers), unknown = std::set<transport::ParticipantId>()](
             transport::ParticipantId server, std::span<const std::byte> bytes) mutable {
    msg::CancelGoal::Response reply;
    const bool decoded = transport::internal::DecodeEnvelope(bytes, reply);
    if (!decoded || reply.return_code != msg::CancelGoal::kErrorUnknownGoalId) return true;
    unknown.insert(server);
    return std::ranges::all_of(servers(), [&](const auto& one) { return unknown.contains(one); });
  };
}

// Whether it cancels one goal. Without an id it cancels all, and each server confirms it for its
// own goals, also the server of another robot.
bool NamesGoal(std::string_view type, std::span<const std::byte> request) {
  msg::CancelGoal::Request cancel;
  return type == msg::CancelGoal::kTypeName &&
         transport::internal::DecodeEnvelope(request, cancel) &&
         cancel.goal_info.goal_id != msg::Uuid();
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
      session_(std::to_string(WallNanoseconds())),
      every_second_(node.loop().Every(std::chrono::seconds(1), [this] { PingAll(); })) {}

FoxgloveServer::~FoxgloveServer() = default;

http::WebSocketHandlers FoxgloveServer::OnWebSocket(std::shared_ptr<http::WebSocket> socket,
                                                    std::function<bool()> may_act) {
  const std::uint64_t id = next_client_++;
  auto& client = clients_[id];
  client = std::make_unique<Client>(id, std::move(socket), std::move(may_act),
                                    options_.guards.uptime_ms());
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
  handlers.on_pong = [client = client.get()](const std::string& uptime_ms) {
    client->OnPong(uptime_ms);
  };
  handlers.on_closed = [this, id] { OnClosed(id); };
  return handlers;
}

void FoxgloveServer::OnClosed(std::uint64_t id) {
  clients_.erase(id);
  OpenReaders();
}

void FoxgloveServer::PingAll() {
  if (clients_.empty()) return;
  const std::string uptime_ms = std::to_string(options_.guards.uptime_ms());
  for (const auto& [id, client] : clients_) client->socket->Ping(uptime_ms);
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
    if (!client.may_act()) {
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
      client.published[channel.id] = {channel.topic, type, std::move(writer).value(), ""};
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
  const WhyNot why = WhyNotPublished(client, found->second.topic,
                                     IsMessageNeverLate(found->second.type, message.data));
  const std::string refused = why ? why->message : "";
  const bool is_new = std::exchange(found->second.refused, refused) != refused;
  if (why) {
    if (!is_new) return;
    return client.Send(
        Status(StatusLevel::kError, found->second.topic + " is not published: " + refused));
  }
  const auto written = found->second.writer->Write({message.data.begin(), message.data.end()});
  if (!written) {
    client.Send(Status(StatusLevel::kError, found->second.topic + ": " + written.error().message));
  }
}

FoxgloveServer::WhyNot FoxgloveServer::WhyNotPublished(const Client& client,
                                                       const std::string& topic,
                                                       bool never_late) const {
  if (!client.may_act()) {
    return Error{kCodePermissionDenied, std::string("publishing ") + kNeedsLogin};
  }
  if (auto late = never_late ? std::nullopt : options_.guards.why_late(client.seen_ms)) return late;
  if (auto why = options_.guards.why_not_meant()) return why;
  return options_.guards.why_not_published(topic);
}

FoxgloveServer::OpenService* FoxgloveServer::FindService(std::uint32_t id) {
  const auto found = std::find_if(services_.begin(), services_.end(),
                                  [id](const auto& service) { return service.second.id == id; });
  return found == services_.end() ? nullptr : &found->second;
}

bool FoxgloveServer::IsOfController(const OpenService& service) const {
  return NamesMachine(service.type) &&
         service.name.starts_with(transport::ResolveName(options_.name_space, "musher/"));
}

FoxgloveServer::WhyNot FoxgloveServer::WhyNotCalled(const Client& client,
                                                    const OpenService& service,
                                                    const ServiceCall& call) const {
  const bool reads = IsReading(service.type);
  if (!reads && !client.may_act()) {
    return Error{kCodePermissionDenied, "calling /" + service.name + " " + kNeedsLogin};
  }
  if (call.encoding != "cdr" || !IsLittleEndianCdr(call.data)) {
    return Error{kCodeParametersInvalid, "a request has to be little-endian CDR"};
  }
  if (service.type == msg::ActuatorCommand::kTypeName) {
    return Error{kCodePermissionDenied,
                 "/" + service.name + " is called by the controller alone; call /" +
                     transport::ResolveName(options_.name_space, "musher/set_state")};
  }
  if (reads) return std::nullopt;
  if (NamesMachine(service.type) && !IsOfController(service)) {
    return Error{kCodeTargetBusy, "/" + service.name +
                                      " is of another namespace; connect to the musher view of "
                                      "that robot. Nothing was done"};
  }
  if (NamesMachine(service.type) && !options_.guards.leader()) {
    return Error{kCodeNetError, "no controller leads the machine. Nothing was done"};
  }
  const msg::Bytes request = RequestBytes(call);
  if (!IsNeverLate(service.type, request, options_.guards.only_lowers)) {
    if (auto late = options_.guards.why_late(client.seen_ms)) return late;
  }
  return IsStopping(service.type, request) ? std::nullopt : options_.guards.why_not_meant();
}

void FoxgloveServer::On(Client& client, const ServiceCall& call) {
  PermittedCall permitted{client.id, call.service, call.call, {}};
  OpenService* const service = FindService(call.service);
  if (service == nullptr) return Fail(permitted, "the service is not there any more");
  if (const auto why = WhyNotCalled(client, *service, call)) return Fail(permitted, why->message);
  if (!service->client) {
    auto made = transport::RawClient::Make(node_, service->name, service->type, {});
    if (!made) return Fail(permitted, made.error().message);
    service->client = std::move(made).value();
  }
  permitted.fields.assign(call.data.begin() + kHeader, call.data.end());
  if (IsReading(service->type) || NamesMachine(service->type) ||
      IsStopping(service->type, RequestBytes(call))) {
    return Send(permitted);
  }
  const auto servers = [this, id = call.service] {
    const OpenService* const now = FindService(id);
    return now == nullptr || !now->client ? Participants() : now->client->Servers();
  };
  options_.guards.check_servers(ActuatorOf(service->name), servers,
                                [this, permitted](const WhyNot& why) {
                                  if (why) return Fail(permitted, why->message);
                                  Send(permitted);
                                });
}

void FoxgloveServer::Send(const PermittedCall& call) {
  OpenService* const service = FindService(call.service);
  if (service == nullptr || !service->client) {
    return Fail(call, "the service is not there any more");
  }
  const std::optional<Leader> leader = options_.guards.leader();
  const msg::RequestId id = service->client->NextId();
  const bool of_controller = leader && IsOfController(*service);
  auto request = RequestFor(of_controller ? leader->machine : MachineIdentity(), service->type, id,
                            call.fields);
  if (!request) return Fail(call, request.error().message);
  const auto servers = [this, number = call.service] {
    const OpenService* const now = FindService(number);
    return now == nullptr || !now->client ? Participants() : now->client->Servers();
  };
  transport::RawClient::Counts counts;
  if (NamesGoal(service->type, request.value())) {
    counts = CountsOfCancel(servers);
  } else if (IsStopping(service->type, request.value())) {
    counts = [this, servers](transport::ParticipantId server,
                             std::span<const std::byte> /*reply*/) {
      return options_.guards.counts(server, servers());
    };
  }
  service->client->Call(
      id, std::move(request).value(), kCallTime,
      [this, call](const Result<std::span<const std::byte>>& reply) {
        OnReply(call.client, call.service, call.call, reply);
      },
      of_controller ? leader->participant : transport::ParticipantId(0), std::move(counts));
}

void FoxgloveServer::Fail(const PermittedCall& call, const std::string& why) {
  const auto client = clients_.find(call.client);
  if (client == clients_.end()) return;
  client->second->Send(ServiceCallFailure(call.service, call.call, why));
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
