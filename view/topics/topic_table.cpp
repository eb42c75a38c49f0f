#include "musher/view/topics/topic_table.hpp"

#include "musher/view/record/qos_text.hpp"
#include "musher/view/record/topic_choice.hpp"
#include "musher/view/record/type_names.hpp"

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

std::optional<TopicTable::Source> TopicTable::SourceOf(const std::string& name) const {
  std::optional<Source> source;
  std::vector<transport::Qos> offered;
  for (const auto& [id, endpoint] : endpoints_) {
    if (!endpoint.writer || RosTopic(endpoint.topic) != name) continue;
    if (!source) source = Source{endpoint.type, {}};
    transport::Qos qos;
    qos.reliability = endpoint.reliability;
    qos.durability = endpoint.durability;
    if (!endpoint.partition.empty()) qos.partition = transport::kEveryPartition;
    offered.push_back(qos);
  }
  if (source) source->qos = QosMatchingAll(offered);
  return source;
}

}  // namespace musher::view
