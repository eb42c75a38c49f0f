#include "musher/view/topics/topic_table.hpp"

#include "musher/view/topics/reader_qos.hpp"
#include "musher/view/topics/topic_choice.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::view {

bool TopicTable::OnFound(const transport::DiscoveredEndpoint& endpoint) {
  if (RosTopic(endpoint.topic).empty()) return false;
  endpoints_[endpoint.id] = endpoint;
  return true;
}

bool TopicTable::OnLost(transport::EndpointId id) {
  return endpoints_.erase(id) > 0;
}

std::vector<ListedTopic> TopicTable::List() const {
  std::map<std::pair<std::string, std::string>, ListedTopic> topics;
  for (const auto& [id, endpoint] : endpoints_) {
    const std::string name = RosTopic(endpoint.topic);
    ListedTopic& topic = topics[{name, endpoint.type}];
    topic.name = name;
    topic.dds_type = endpoint.type;
    ++(endpoint.writer ? topic.publishers : topic.subscribers);
  }
  std::vector<ListedTopic> list;
  list.reserve(topics.size());
  for (auto& [key, topic] : topics) {
    topic.type = RosType(topic.dds_type);
    if (topic.type.empty()) topic.type = topic.dds_type;
    list.push_back(topic);
  }
  return list;
}

std::vector<transport::DiscoveredEndpoint> TopicTable::EndpointsOf(const std::string& name) const {
  std::vector<transport::DiscoveredEndpoint> found;
  for (const auto& [id, endpoint] : endpoints_) {
    if (RosTopic(endpoint.topic) == name) found.push_back(endpoint);
  }
  return found;
}

std::optional<TopicTable::Source> TopicTable::SourceOf(const std::string& name) const {
  std::optional<Source> source;
  std::vector<transport::Qos> offered;
  for (const auto& [id, endpoint] : endpoints_) {
    if (!endpoint.writer || RosTopic(endpoint.topic) != name) continue;
    if (!source) source = Source{endpoint.type, {}};
    offered.push_back(QosOf(endpoint));
  }
  if (source) source->qos = QosMatchingAll(offered);
  return source;
}

}  // namespace musher::view
