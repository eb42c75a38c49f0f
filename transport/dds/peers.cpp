#include "musher/transport/dds/peers.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string_view>

#include "musher/base/checksum.hpp"
#include "musher/transport/dds/entity.hpp"
#include "musher/transport/dds/topic_watch.hpp"

namespace musher::transport::dds {
namespace {

constexpr int kSamplesPerRead = 64;

// The living instances of a builtin topic. Its reader gets them when it is created.
template <class Sample>
void ReadAll(dds_entity_t participant, dds_entity_t topic,
             const std::function<void(const Sample&)>& on_sample) {
  const Entity reader(dds_create_reader(participant, topic, nullptr, nullptr));
  for (int count = kSamplesPerRead; count == kSamplesPerRead;) {
    std::array<void*, kSamplesPerRead> samples{};
    std::array<dds_sample_info_t, kSamplesPerRead> infos{};
    count = dds_take(reader.get(), samples.data(), infos.data(), kSamplesPerRead, kSamplesPerRead);
    for (int i = 0; i < count; ++i) {
      if (infos[i].valid_data && infos[i].instance_state == DDS_ALIVE_INSTANCE_STATE) {
        on_sample(*static_cast<const Sample*>(samples[i]));
      }
    }
    if (count > 0) dds_return_loan(reader.get(), samples.data(), count);
  }
}

// The text is the peer's.
std::string Shown(std::string_view text) {
  constexpr std::size_t kLongest = 256;
  std::string shown(text.substr(0, kLongest));
  std::erase_if(shown, [](unsigned char c) { return c < ' ' || c == 0x7F; });
  return shown;
}

// By Cyclone's name of the property, or by the name in another DDS.
std::string PropertyOf(const dds_qos_t* qos, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    char* value = nullptr;
    if (!dds_qget_prop(qos, name, &value) || value == nullptr) continue;
    const std::unique_ptr<char, void (*)(void*)> freed(value, dds_free);
    return Shown(value);
  }
  return {};
}

// "enclave=/;musher=alice@dog1;"
std::string NameIn(const dds_qos_t* qos) {
  void* data = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(qos, &data, &size) || data == nullptr) return {};
  const std::unique_ptr<void, void (*)(void*)> freed(data, dds_free);
  std::string_view text(static_cast<const char*>(data), size);
  const std::size_t begin = text.find(kNameKey);
  if (begin == std::string_view::npos) return {};
  text.remove_prefix(begin + kNameKey.size());
  return Shown(text.substr(0, text.find(';')));
}

std::int32_t NumberIn(std::string_view text) {
  std::int32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && number > 0 ? number : 0;
}

// "rr/planner_server/get_parametersReply" is of the node "/planner_server"; empty: of none.
std::string NodeIn(std::string_view topic) {
  constexpr std::string_view kPrefix = "rr/";
  if (!topic.starts_with(kPrefix)) return {};
  for (const std::string_view end : {"/get_type_descriptionReply", "/get_parametersReply"}) {
    if (!topic.ends_with(end) || topic.size() <= kPrefix.size() + end.size()) continue;
    topic.remove_suffix(end.size());
    return "/" + Shown(topic.substr(kPrefix.size()));
  }
  return {};
}

}  // namespace

ParticipantId IdOfParticipant(const dds_guid_t& guid) {
  return ParticipantId(Fnv1a({reinterpret_cast<const char*>(&guid.v), sizeof(guid.v)}) |
                       1U);  // not 0, which means none
}

std::vector<PeerInfo> PeersOf(dds_entity_t own) {
  dds_guid_t own_guid{};
  dds_get_guid(own, &own_guid);
  std::vector<PeerInfo> peers;
  ReadAll<dds_builtintopic_participant_t>(
      own, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, [&](const dds_builtintopic_participant_t& sample) {
        PeerInfo peer;
        peer.id = IdOfParticipant(sample.key);
        if (peer.id == IdOfParticipant(own_guid)) return;
        peer.pid = NumberIn(PropertyOf(sample.qos, {"__Pid", "fastdds.physical_data.process"}));
        peer.host = PropertyOf(sample.qos, {"__Hostname", "fastdds.physical_data.host"});
        peer.host.resize(std::min(peer.host.find(':'), peer.host.size()));  // "dog1:<a number>"
        peer.vendor = static_cast<std::uint16_t>(sample.key.v[0] << 8U | sample.key.v[1]);
        peer.name = NameIn(sample.qos);
        peers.push_back(std::move(peer));
      });
  return peers;
}

// A client publishes the writers of its node's own services before the writer of its requests.
std::string RosNodeOf(dds_entity_t own, ParticipantId participant) {
  std::set<std::string> nodes;
  ReadAll<dds_builtintopic_endpoint_t>(own, DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                       [&](const dds_builtintopic_endpoint_t& sample) {
                                         if (IdOfParticipant(sample.participant_key) != participant)
                                           return;
                                         const std::string node = NodeIn(sample.topic_name);
                                         if (!node.empty()) nodes.insert(node);
                                       });
  return ListOf(nodes);
}

std::vector<EndpointId> WritersOf(dds_entity_t own, ParticipantId participant,
                                  const std::string& topic) {
  std::vector<EndpointId> writers;
  ReadAll<dds_builtintopic_endpoint_t>(
      own, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, [&](const dds_builtintopic_endpoint_t& sample) {
        if (sample.topic_name != topic || IdOfParticipant(sample.participant_key) != participant) {
          return;
        }
        writers.push_back(EndpointIdOf(std::span<const std::uint8_t, 16>(sample.key.v)));
      });
  return writers;
}

std::string ListOf(const std::set<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string text;
  std::size_t listed = 0;
  for (const std::string& name : names) {
    if (listed++ < kMost) text += (text.empty() ? "" : ", ") + name;
  }
  return listed > kMost ? text + " and " + std::to_string(listed - kMost) + " more" : text;
}

}  // namespace musher::transport::dds
