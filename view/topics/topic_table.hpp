#pragma once
// The topics of the domain with their types and the QoS of their writers, from what discovery
// finds. Names and types are ROS 2's: "/chat", "std_msgs/msg/String". Pure.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "musher/transport/dds/topic_watch.hpp"

namespace musher::view {

struct ListedTopic {
  std::string name;
  std::string type;      // ROS 2's; of another form, as on DDS
  std::string dds_type;  // "std_msgs::msg::dds_::String_"
  std::size_t publishers = 0;
  std::size_t subscribers = 0;

  friend bool operator==(const ListedTopic&, const ListedTopic&) = default;
};

class TopicTable {
 public:
  // Whether the list has changed.
  bool OnFound(const transport::DiscoveredEndpoint& endpoint);
  bool OnLost(transport::EndpointId id);

  // Topics by name, then type. Requests and replies of services are no topics.
  std::vector<ListedTopic> List() const;

  // Its writers and readers.
  std::vector<transport::DiscoveredEndpoint> EndpointsOf(const std::string& name) const;

  // The type of its writers on DDS, and a QoS that matches all of them; nullopt: it has no writer.
  struct Source {
    std::string dds_type;
    transport::Qos qos;

    friend bool operator==(const Source&, const Source&) = default;
  };
  std::optional<Source> SourceOf(const std::string& name) const;

 private:
  std::map<transport::EndpointId, transport::DiscoveredEndpoint> endpoints_;
};

}  // namespace musher::view
