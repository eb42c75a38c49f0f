#include "musher/transport/dds/ros_nodes.hpp"

#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "musher/messages/before_iron.hpp"
#include "musher/messages/rmw_dds_common/participant_entities.hpp"
#include "musher/transport/dds/participant.hpp"
#include "musher/transport/dds/peers.hpp"
#include "musher/transport/dds/topic_watch.hpp"

namespace musher::transport {
namespace {

constexpr std::size_t kMostProcesses = 1000;  // any number of participants may come
constexpr std::size_t kMostWaiting = 16;
constexpr std::size_t kMostBytes = 1 << 20;  // of one process

// `Info`: of this distribution of ROS 2, or of those before Iron.
template <class Info>
std::optional<std::map<EndpointId, std::string>> NodesOf(std::span<const std::byte> bytes) {
  const auto info = msg::Decode<Info>(bytes);
  if (!info || msg::Encode(*info).size() != bytes.size()) return std::nullopt;
  std::map<EndpointId, std::string> nodes;
  for (const auto& node : info->node_entities_info_seq) {
    const std::string& above = node.node_namespace;
    const std::string name = above + (above.ends_with('/') ? "" : "/") + node.node_name;
    for (const auto* gids : {&node.reader_gid_seq, &node.writer_gid_seq}) {
      for (const auto& gid : *gids) {
        nodes[EndpointIdOf(std::span<const std::uint8_t, 16>(gid.data.data(), 16))] = name;
      }
    }
  }
  return nodes;
}

}  // namespace

RosNodes::RosNodes(Node& node) : node_(node) {
  if (dds::ParticipantOf(node) == nullptr) return;
  ReaderCallbacks callbacks;
  callbacks.on_sample = [this](std::span<const std::byte> bytes, const SampleInfo& info) {
    Keep(bytes, info.writer);
  };
  callbacks.on_writer_lost = [this](EndpointId process) { processes_.erase(process); };
  auto reader =
      node.MakeRawReader("ros_discovery_info", std::string(msg::ParticipantEntitiesInfo::kTypeName),
                         kLatchedFromManyQos, std::move(callbacks));
  if (reader) reader_ = std::move(reader).value();
}

void RosNodes::Keep(std::span<const std::byte> bytes, EndpointId process) {
  if (bytes.size() > kMostBytes) {
    processes_.erase(process);
    return;
  }
  if (processes_.size() >= kMostProcesses && !processes_.contains(process)) return;
  processes_[process].newest.emplace(bytes.begin(), bytes.end());
  CallKnown();
}

bool RosNodes::WhenKnown(const std::string& service, ParticipantId participant,
                         std::function<void()> then) const {
  const Time now = node_.loop().Now();
  if (first_waited_.size() >= kMostProcesses) first_waited_.clear();
  const Time until = first_waited_.try_emplace(participant, now).first->second + kKnownWithin;
  if (!reader_ || now >= until || waiting_.size() >= kMostWaiting) return false;
  waiting_.push_back({service, participant, std::move(then), nullptr});
  const auto one = std::prev(waiting_.end());
  one->until = node_.loop().At(until, [this, one] {
    const auto ended = std::move(one->then);
    waiting_.erase(one);
    ended();
  });
  return true;
}

// What is called may wait again.
void RosNodes::CallKnown() const {
  std::list<WaitingCall> known;
  for (auto one = waiting_.begin(); one != waiting_.end();) {
    const auto next = std::next(one);
    if (!CallersOf(one->service, one->participant).empty()) {
      known.splice(known.end(), waiting_, one);
    }
    one = next;
  }
  for (const WaitingCall& one : known) one.then();
}

const RosNodes::Nodes& RosNodes::NodesIn(Process& process) {
  if (!process.newest) return process.nodes;
  const msg::Bytes bytes = *std::exchange(process.newest, std::nullopt);
  auto nodes = NodesOf<msg::ParticipantEntitiesInfo>(bytes);
  if (!nodes) nodes = NodesOf<msg::ParticipantEntitiesInfoBeforeIron>(bytes);
  if (nodes) process.nodes = *std::move(nodes);
  return process.nodes;
}

std::string RosNodes::NodeOf(EndpointId endpoint) const {
  for (auto& [id, process] : processes_) {
    const Nodes& nodes = NodesIn(process);
    const auto node = nodes.find(endpoint);
    if (node != nodes.end()) return node->second;
  }
  return {};
}

std::string RosNodes::CallersOf(const std::string& service, ParticipantId participant) const {
  dds::Participant* own = dds::ParticipantOf(node_);
  if (own == nullptr) return node_.RosNodeOf(participant);
  std::set<std::string> names;
  const auto writers = dds::WritersOf(own->get(), participant, "rq/" + service + "Request");
  for (const EndpointId writer : writers) names.insert(NodeOf(writer));
  // If there are several clients, the node of the caller may not be known.
  if (writers.size() > 1 && names.erase("") != 0) names.insert("a node that is not known");
  // A client whose node is not known may be the caller.
  const bool known = !names.empty() && !names.contains("");
  return known ? dds::ListOf(names) : node_.RosNodeOf(participant);
}

}  // namespace musher::transport
