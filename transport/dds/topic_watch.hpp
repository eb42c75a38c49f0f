#pragma once
// The writers and readers of all other processes in the domain, by DDS's builtin topics.

#include <functional>
#include <memory>
#include <string>

#include "musher/transport/node.hpp"

namespace musher::transport {

struct DiscoveredEndpoint {
  EndpointId id = 0;
  ParticipantId participant = 0;
  bool writer = false;
  std::string topic;  // "rt/chat"
  std::string type;   // "std_msgs::msg::dds_::String_"
  Qos::Reliability reliability = Qos::Reliability::kReliable;
  Qos::Durability durability = Qos::Durability::kVolatile;
  std::string partition;  // empty: the default one, or several
};

// Watches until it is dropped.
class TopicWatch {
 public:
  virtual ~TopicWatch() = default;
};

// `on_found` and `on_lost` run on the loop; existing endpoints are reported at once. `node` is one
// of MakeDdsNode. Loop thread only.
Result<std::unique_ptr<TopicWatch>> WatchTopics(
    Node& node, std::function<void(const DiscoveredEndpoint&)> on_found,
    std::function<void(EndpointId id)> on_lost);

}  // namespace musher::transport
