#include "musher/transport/dds/node_graph.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "musher/messages/before_iron.hpp"
#include "musher/transport/dds/qos.hpp"
#include "musher/transport/dds/raw_type.hpp"
#include "musher/transport/dds/type_tag.hpp"

namespace musher::transport::dds {

namespace {

constexpr const char* kTopic = "ros_discovery_info";
constexpr std::size_t kLongestName = 255;  // that ROS 2 takes

std::vector<msg::Gid>& EndpointsOf(msg::NodeEntitiesInfo& node, NodeGraph::Kind kind) {
  return kind == NodeGraph::Kind::kReader ? node.reader_gid_seq : node.writer_gid_seq;
}

}  // namespace

msg::Gid EntityGid(dds_entity_t entity) {
  dds_guid_t guid{};
  dds_get_guid(entity, &guid);
  msg::Gid gid;
  static_assert(sizeof(guid.v) == sizeof(gid.data));
  std::copy(std::begin(guid.v), std::end(guid.v), gid.data.begin());
  return gid;
}

NodeGraph::NodeGraph(dds_entity_t participant, RosDistro distro)
    : participant_(EntityGid(participant)), distro_(distro) {
  const std::string type(msg::ParticipantEntitiesInfo::kTypeName);
  const dds_entity_t topic = CreateRawTopic(participant, kTopic, type);
  if (topic < 0) return;
  topic_ = Entity(topic);
  const QosPtr qos = MakeQos(kLatchedQos, TypeTag(type));
  writer_ = Entity(dds_create_writer(participant, topic, qos.get(), nullptr));
}

NodeGraph::Nodes::iterator NodeGraph::Add(const std::string& name_space, const std::string& name) {
  const std::lock_guard lock(mutex_);
  changed_ = true;
  return nodes_.insert(nodes_.end(), {NamespaceFrom(name_space), NodeNameFrom(name), {}, {}});
}

void NodeGraph::Remove(Nodes::iterator node) {
  const std::lock_guard lock(mutex_);
  changed_ = true;
  nodes_.erase(node);
}

void NodeGraph::Add(Nodes::iterator node, Kind kind, const msg::Gid& endpoint) {
  const std::lock_guard lock(mutex_);
  changed_ = true;
  EndpointsOf(*node, kind).push_back(endpoint);
}

void NodeGraph::Remove(Nodes::iterator node, Kind kind, const msg::Gid& endpoint) {
  const std::lock_guard lock(mutex_);
  changed_ = true;
  std::erase(EndpointsOf(*node, kind), endpoint);
}

// When its last node is destroyed, nothing is published: the participant is destroyed, too.
void NodeGraph::Publish() {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(changed_, false) || writer_.get() <= 0 || nodes_.empty()) return;
  const msg::ParticipantEntitiesInfo info{participant_, {nodes_.begin(), nodes_.end()}};
  msg::Bytes bytes =
      distro_ < RosDistro::kIron ? msg::Encode(msg::BeforeIron(info)) : msg::Encode(info);
  const RawSample sample{bytes};
  if (dds_write(writer_.get(), &sample) != DDS_RETCODE_OK) changed_ = true;  // with the next change
}

std::string NodeNameFrom(std::string_view name) {
  std::string text(name.substr(0, kLongestName));
  for (char& c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  const bool begins_well = !text.empty() && std::isdigit(static_cast<unsigned char>(text[0])) == 0;
  return begins_well ? text : "node_" + text;
}

std::string NamespaceFrom(std::string_view name_space) {
  while (name_space.starts_with('/')) name_space.remove_prefix(1);
  while (name_space.ends_with('/')) name_space.remove_suffix(1);
  return "/" + std::string(name_space);
}

}  // namespace musher::transport::dds
