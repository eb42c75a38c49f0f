#include "musher/view/foxglove/protocol.hpp"

#include <cstring>
#include <limits>

#include "musher/view/json/json.hpp"

namespace musher::view::foxglove {
namespace {

constexpr std::uint8_t kMessageData = 1;         // both ways
constexpr std::uint8_t kServiceCallRequest = 2;  // from a client
constexpr std::uint8_t kServiceCallResponse = 3;
constexpr std::string_view kCdr = "cdr";

Error Malformed(const std::string& what) {
  return {kCodeParametersInvalid, "malformed message: " + what};
}

// The numbers of a JSON message, with what is missing or wrong as an Error.
Result<std::uint32_t> NumberOf(const Json& object, const char* name) {
  const auto found = object.is_object() ? object.find(name) : object.end();
  if (!object.is_object() || found == object.end() || !found->is_number_unsigned() ||
      found->get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
    return Malformed("'" + std::string(name) + "' has to be an integer of 32 bits");
  }
  return found->get<std::uint32_t>();
}

Result<std::string> TextOf(const Json& object, const char* name) {
  const auto found = object.is_object() ? object.find(name) : object.end();
  if (!object.is_object() || found == object.end() || !found->is_string()) {
    return Malformed("'" + std::string(name) + "' has to be a text");
  }
  return found->get<std::string>();
}

Result<Json> ListOf(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_array() || found->size() > kMostItems) {
    return Malformed("'" + std::string(name) + "' has to be a list of at most " +
                     std::to_string(kMostItems));
  }
  return *found;
}

Result<std::vector<std::uint32_t>> NumbersOf(const Json& object, const char* name) {
  const auto list = ListOf(object, name);
  if (!list) return list.error();
  std::vector<std::uint32_t> numbers;
  for (const Json& item : list.value()) {
    if (!item.is_number_unsigned() ||
        item.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
      return Malformed("'" + std::string(name) + "' has to be a list of integers of 32 bits");
    }
    numbers.push_back(item.get<std::uint32_t>());
  }
  return numbers;
}

Result<FromClient> ReadSubscribe(const Json& message) {
  const auto list = ListOf(message, "subscriptions");
  if (!list) return list.error();
  Subscribe subscribe;
  for (const Json& item : list.value()) {
    const auto id = NumberOf(item, "id");
    const auto channel = NumberOf(item, "channelId");
    if (!id) return id.error();
    if (!channel) return channel.error();
    subscribe.subscriptions.push_back({id.value(), channel.value()});
  }
  return FromClient(std::move(subscribe));
}

Result<FromClient> ReadAdvertise(const Json& message) {
  const auto list = ListOf(message, "channels");
  if (!list) return list.error();
  ClientAdvertise advertise;
  for (const Json& item : list.value()) {
    const auto id = NumberOf(item, "id");
    const auto topic = TextOf(item, "topic");
    const auto encoding = TextOf(item, "encoding");
    const auto schema = TextOf(item, "schemaName");
    if (!id) return id.error();
    for (const auto* text : {&topic, &encoding, &schema}) {
      if (!*text) return text->error();
    }
    advertise.channels.push_back({id.value(), topic.value(), encoding.value(), schema.value()});
  }
  return FromClient(std::move(advertise));
}

// The little-endian number at the begin of the bytes, which are moved behind it.
std::uint32_t TakeNumber(std::span<const std::byte>& bytes) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data(), sizeof number);
  bytes = bytes.subspan(sizeof number);
  return number;
}

template <class T>
void Append(std::string& text, T number) {
  std::array<char, sizeof number> bytes{};
  std::memcpy(bytes.data(), &number, sizeof number);
  text.append(bytes.data(), bytes.size());
}
void Append(std::string& text, std::span<const std::byte> bytes) {
  text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

OrderedJson Schema(const std::string& type, std::string_view schema) {
  return {
      {"encoding", kCdr}, {"schemaName", type}, {"schemaEncoding", "ros2msg"}, {"schema", schema}};
}

}  // namespace

Result<FromClient> ReadText(std::string_view text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object()) return Malformed("it is not a JSON object");
  const auto op = TextOf(message, "op");
  if (!op) return op.error();
  if (op.value() == "subscribe") return ReadSubscribe(message);
  if (op.value() == "advertise") return ReadAdvertise(message);
  if (op.value() == "unsubscribe") {
    auto numbers = NumbersOf(message, "subscriptionIds");
    if (!numbers) return numbers.error();
    return FromClient(Unsubscribe{std::move(numbers).value()});
  }
  if (op.value() == "unadvertise") {
    auto numbers = NumbersOf(message, "channelIds");
    if (!numbers) return numbers.error();
    return FromClient(ClientUnadvertise{std::move(numbers).value()});
  }
  return FromClient(Ignored{});
}

Result<FromClient> ReadBinary(std::span<const std::byte> bytes) {
  if (bytes.empty()) return Malformed("it is empty");
  const auto op = static_cast<std::uint8_t>(bytes.front());
  std::span<const std::byte> rest = bytes.subspan(1);
  if (op == kMessageData) {
    if (rest.size() < 4) return Malformed("a message has an id of 4 bytes");
    const std::uint32_t channel = TakeNumber(rest);
    return FromClient(ClientMessage{channel, rest});
  }
  if (op != kServiceCallRequest) return Malformed("its operation is " + std::to_string(op));
  if (rest.size() < 12) return Malformed("the call of a service begins with 12 bytes");
  ServiceCall call;
  call.service = TakeNumber(rest);
  call.call = TakeNumber(rest);
  const std::uint32_t size = TakeNumber(rest);
  if (size > rest.size()) return Malformed("the encoding's name is longer than the message");
  call.encoding.assign(reinterpret_cast<const char*>(rest.data()), size);
  call.data = rest.subspan(size);
  return FromClient(std::move(call));
}

std::string ServerInfo(std::string_view name, std::string_view session) {
  return Dumped({{"op", "serverInfo"},
                 {"name", name},
                 {"capabilities", {"clientPublish", "services"}},
                 {"supportedEncodings", {kCdr}},
                 {"metadata", {{"ROS_DISTRO", "jazzy"}}},
                 {"sessionId", session}});
}

std::string Status(StatusLevel level, std::string_view message, std::string_view id) {
  OrderedJson status = {{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}};
  if (!id.empty()) status["id"] = id;
  return Dumped(status);
}

std::string Advertise(const std::vector<Channel>& channels) {
  OrderedJson list = OrderedJson::array();
  for (const Channel& channel : channels) {
    OrderedJson one = {{"id", channel.id}, {"topic", channel.topic}};
    one.update(Schema(channel.schema_name, channel.schema));
    list.push_back(std::move(one));
  }
  return Dumped({{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string Unadvertise(const std::vector<std::uint32_t>& channels) {
  return Dumped({{"op", "unadvertise"}, {"channelIds", channels}});
}

std::string AdvertiseServices(const std::vector<Service>& services) {
  OrderedJson list = OrderedJson::array();
  for (const Service& service : services) {
    list.push_back({{"id", service.id},
                    {"name", service.name},
                    {"type", service.type},
                    {"request", Schema(service.type + "_Request", service.request)},
                    {"response", Schema(service.type + "_Response", service.response)},
                    // As older clients read them.
                    {"requestSchema", service.request},
                    {"responseSchema", service.response}});
  }
  return Dumped({{"op", "advertiseServices"}, {"services", std::move(list)}});
}

std::string UnadvertiseServices(const std::vector<std::uint32_t>& services) {
  return Dumped({{"op", "unadvertiseServices"}, {"serviceIds", services}});
}

std::string ServiceCallFailure(std::uint32_t service, std::uint32_t call, std::string_view why) {
  return Dumped(
      {{"op", "serviceCallFailure"}, {"serviceId", service}, {"callId", call}, {"message", why}});
}

std::string MessageData(std::uint32_t subscription, std::uint64_t wall_ns,
                        std::span<const std::byte> cdr) {
  std::string message;
  message.reserve(13 + cdr.size());
  Append(message, kMessageData);
  Append(message, subscription);
  Append(message, wall_ns);
  Append(message, cdr);
  return message;
}

std::string ServiceCallResponse(std::uint32_t service, std::uint32_t call,
                                std::span<const std::byte> head, std::span<const std::byte> body) {
  std::string message;
  Append(message, kServiceCallResponse);
  Append(message, service);
  Append(message, call);
  Append(message, static_cast<std::uint32_t>(kCdr.size()));
  message += kCdr;
  Append(message, head);
  Append(message, body);
  return message;
}

}  // namespace musher::view::foxglove
