// The requests of clients.

#include <algorithm>
#include <array>

#include "musher/view/foxglove/client.hpp"
#include "musher/view/record/type_names.hpp"

namespace musher::view::foxglove {
namespace {

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
