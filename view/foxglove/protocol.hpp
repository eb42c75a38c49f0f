#pragma once
// The messages of Foxglove's WebSocket protocol (subprotocol foxglove.websocket.v1), as far as a
// robot needs them. Texts are JSON, binary messages little-endian. Pure; threads: any.
//
// What a client sends is read with an Error that says what is wrong: nothing is trusted.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::view::foxglove {

inline constexpr const char* kSubprotocol = "foxglove.websocket.v1";
inline constexpr std::size_t kMostItems = 1000;  // of a list in a message of a client

struct Subscribe {
  struct One {
    std::uint32_t id = 0;  // chosen by the client
    std::uint32_t channel = 0;
  };
  std::vector<One> subscriptions;
};
struct Unsubscribe {
  std::vector<std::uint32_t> subscriptions;
};
struct ClientAdvertise {
  struct Channel {
    std::uint32_t id = 0;  // chosen by the client
    std::string topic;     // "/chat"
    std::string encoding;  // "cdr"
    std::string schema;    // "std_msgs/msg/String"
  };
  std::vector<Channel> channels;
};
struct ClientUnadvertise {
  std::vector<std::uint32_t> channels;
};
struct ClientMessage {
  std::uint32_t channel = 0;
  std::span<const std::byte> data;  // of the bytes that were read
};
struct ServiceCall {
  std::uint32_t service = 0;
  std::uint32_t call = 0;
  std::string encoding;
  std::span<const std::byte> data;  // of the bytes that were read
};
struct Ignored {};  // an operation that this server does not offer

using FromClient = std::variant<Subscribe, Unsubscribe, ClientAdvertise, ClientUnadvertise,
                                ClientMessage, ServiceCall, Ignored>;

Result<FromClient> ReadText(std::string_view text);
Result<FromClient> ReadBinary(std::span<const std::byte> bytes);

struct Channel {
  std::uint32_t id = 0;
  std::string topic;
  std::string schema_name;  // "std_msgs/msg/String"
  std::string_view schema;  // its definition
};
struct Service {
  std::uint32_t id = 0;
  std::string name;  // "/musher/set_state"
  std::string type;  // "musher_msgs/srv/SetState"
  std::string_view request;
  std::string_view response;
};

enum class StatusLevel { kInfo = 0, kWarning = 1, kError = 2 };

std::string ServerInfo(std::string_view name, std::string_view session);
std::string Status(StatusLevel level, std::string_view message, std::string_view id = {});
std::string Advertise(const std::vector<Channel>& channels);
std::string Unadvertise(const std::vector<std::uint32_t>& channels);
std::string AdvertiseServices(const std::vector<Service>& services);
std::string UnadvertiseServices(const std::vector<std::uint32_t>& services);
std::string ServiceCallFailure(std::uint32_t service, std::uint32_t call, std::string_view why);
std::string MessageData(std::uint32_t subscription, std::uint64_t wall_ns,
                        std::span<const std::byte> cdr);
// `head` and `body`: the response's bytes in two pieces.
std::string ServiceCallResponse(std::uint32_t service, std::uint32_t call,
                                std::span<const std::byte> head, std::span<const std::byte> body);

}  // namespace musher::view::foxglove
