#include "musher/transport/dds/dds_node.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/user.hpp"
#include "musher/transport/dds/dds_reader.hpp"
#include "musher/transport/dds/dds_writer.hpp"
#include "musher/transport/dds/first_replies.hpp"
#include "musher/transport/dds/participant.hpp"
#include "musher/transport/dds/peers.hpp"
#include "musher/transport/dds/raw_type.hpp"
#include "musher/transport/dds/service_tags.hpp"
#include "musher/transport/dds/settings.hpp"
#include "musher/transport/dds/type_tag.hpp"
#include "musher/transport/network.hpp"
#include "musher/transport/ros_environment.hpp"
#include "musher/transport/security/check.hpp"
#include "musher/transport/udp_sockets.hpp"

namespace musher::transport {

namespace {

constexpr std::size_t kLongestHash = 80;

class DdsNode : public Node {
 public:
  DdsNode(EventLoop& loop, std::shared_ptr<dds::Participant> participant,
          const std::string& name_space, const std::string& name)
      : loop_(loop),
        participant_(std::move(participant)),
        tags_(participant_->get(), participant_->NextNode()),
        listed_(std::make_shared<dds::ListedNode>(loop, participant_->graph(), name_space, name)) {
    listed_->Notify();
  }

  EventLoop& loop() override { return loop_; }
  ParticipantId participant() const override { return participant_->id(); }
  dds::Participant& dds_participant() { return *participant_; }

  Result<std::unique_ptr<RawWriter>> MakeRawWriter(const std::string& topic,
                                                   const std::string& type, const Qos& qos,
                                                   WriterCallbacks callbacks) override {
    loop_.CheckThread();
    const auto core = std::make_shared<dds::WriterCore>(
        loop_, topic, std::move(callbacks), ComparedTag(type), ReportOtherType(topic, type));
    const Result<> opened =
        Open(*core, topic, type, qos, tags_.ForWriter(topic) + dds::TypeTag(type));
    if (!opened) return opened.error();
    return std::unique_ptr<RawWriter>(std::make_unique<dds::DdsWriter>(core, *listed_));
  }

  Result<std::unique_ptr<RawReader>> MakeRawReader(const std::string& topic,
                                                   const std::string& type, const Qos& qos,
                                                   ReaderCallbacks callbacks) override {
    loop_.CheckThread();
    callbacks.on_type_differs = ReportOtherType(topic, type);
    const auto core = std::make_shared<dds::ReaderCore>(
        loop_, std::move(callbacks), qos.partition == kEveryPartition, ComparedTag(type));
    const Result<> opened =
        Open(*core, topic, type, qos, tags_.ForReader(topic) + dds::TypeTag(type) + OwnTag(topic));
    if (!opened) return opened.error();
    return std::unique_ptr<RawReader>(std::make_unique<dds::DdsReader>(core, *listed_));
  }

  std::vector<PeerInfo> Peers() const override { return dds::PeersOf(participant_->get()); }
  std::string RosNodeOf(ParticipantId participant) const override {
    return dds::RosNodeOf(participant_->get(), participant);
  }

 private:
  template <class Core>
  Result<> Open(Core& core, const std::string& topic_name, const std::string& type, const Qos& qos,
                const std::string& user_data) {
    const dds_entity_t participant = participant_->get();
    const dds_entity_t topic = dds::CreateRawTopic(participant, topic_name, type);
    if (topic < 0) return Named(topic_name, dds::DdsError(type + ": no topic", topic));
    const Result<> opened =
        core.Open(participant, dds::Entity(topic), dds::MakeQos(qos, user_data));
    if (!opened) return Named(topic_name, opened.error());
    return Ok();
  }

  // The error of a topic; if the permissions forbid it, with the identity that they are for.
  Error Named(const std::string& topic_name, const Error& error) const {
    const auto& credentials = participant_->credentials();
    if (!credentials || error.code != kCodePermissionDenied) {
      return {error.code, topic_name + ": " + error.message};
    }
    return {error.code, credentials->identity + " may not do that: " +
                            keys::KeyFolder(credentials->keys).Permissions(credentials->identity) +
                            " does not allow " + topic_name};
  }

  // A Musher of another version has more fields, or fewer.
  static std::string ComparedTag(const std::string& type) {
    return type.starts_with("musher_msgs::") ? "" : dds::TypeTag(type);
  }

  std::function<void(ParticipantId, const std::string&)> ReportOtherType(
      const std::string& topic, const std::string& type) const {
    return [this, topic, type](ParticipantId participant, const std::string& hash) {
      ReportPeerFault({participant, topic,
                       "has another definition of " + type + ", " + hash.substr(0, kLongestHash)});
    };
  }

  // On readers of replies: servers of Musher recognise its clients by it.
  static std::string OwnTag(const std::string& topic) {
    return topic.starts_with("rr/") ? std::string(dds::kOwnTag) : "";
  }

  EventLoop& loop_;
  std::shared_ptr<dds::Participant> participant_;
  dds::ServiceTags tags_;
  std::shared_ptr<dds::ListedNode> listed_;
};

}  // namespace

dds::Participant* dds::ParticipantOf(Node& node) {
  auto* own = dynamic_cast<DdsNode*>(&node);
  return own != nullptr ? &own->dds_participant() : nullptr;
}

namespace {

// DDS chooses its network interfaces when a process joins the domain, and keeps them: a process
// that starts before the network is up reaches only its own host for good, and nothing else reports
// it.
void WarnOfLoopbackOnly(const std::string& why) {
  static std::once_flag logged;
  std::call_once(logged, [&] {
    std::fprintf(stderr,
                 "%s: in the lan profile this process is reachable on this host only, until it is "
                 "restarted\n",
                 why.c_str());
  });
}

void WarnWithoutNetwork(const std::vector<InterfaceUse>& uses) {
  std::string why;
  for (const InterfaceUse& use : uses) {
    why += (why.empty() ? " (" : "; ") + use.name + ": " + use.reason;
  }
  if (!why.empty()) why += ")";
  WarnOfLoopbackOnly("no network interface to other hosts is up" + why +
                     "; start it after the network (systemd: Wants= and "
                     "After=network-online.target)");
}

// A process of this host that Cyclone would take for a process of another host: it sends from
// addresses that this process does not have. Over the loopback alone both would reach each other.
// That counts more where a controller runs; elsewhere the connection to other hosts does.
std::optional<OtherAddress> FindUnreachable(int domain_id, bool controller,
                                            const std::vector<std::string>& own) {
  auto other = FindOtherAddress(ReadProcessesBoundElsewhere(own), domain_id, own);
  if (!other || controller || NameLock::IsHeldInDomain(domain_id, "musher/controller")) {
    return other;
  }
  return std::nullopt;
}

// The outer interfaces of this process.
std::vector<std::string> OuterInterfacesFor(const DdsOptions& options, int domain_id) {
  const std::vector<NetworkInterface> present = ReadInterfaces();
  const auto uses = ChooseInterfaces(present, options.interfaces);
  std::vector<std::string> names;
  std::vector<std::string> own;  // their addresses
  for (const InterfaceUse& use : uses) {
    if (!use.used) continue;
    names.push_back(use.name);
    const auto found = std::ranges::find(present, use.name, &NetworkInterface::name);
    own.push_back(found->addresses.front());  // Cyclone uses the first one
  }
  if (names.empty()) {
    WarnWithoutNetwork(uses);
    return names;
  }
  const auto other = FindUnreachable(domain_id, options.controller, own);
  if (!other) return names;
  if (!options.hidden) {
    WarnOfLoopbackOnly("a process of this host" +
                       (other->pid == 0 ? "" : " (pid " + std::to_string(other->pid) + ")") +
                       " uses the address " + other->address + ", and not " + own.front() +
                       " (the address has changed, or their configs name different interfaces)");
  }
  return {};
}

// Unique on a host, for nodes without a name; ROS 2 hides names that begin with '_'.
std::string NodeName(const DdsOptions& options) {
  if (!options.node_name.empty()) return options.node_name;
  const std::string program = program_invocation_short_name;
  return (options.hidden ? "_" : "") + program + "_" + std::to_string(getpid());
}

// What other participants call this process. An emergency stop does not wait for it.
std::string PeerName(const DdsOptions& options) {
  std::string name = options.hidden ? UserAtHostAtOnce()
                                    : "/" + ResolveName(options.name_space, NodeName(options));
  std::erase(name, ';');
  return name;
}

}  // namespace

Result<int> DomainId(const DdsOptions& options) {
  constexpr int kHighest = 232;  // the ports of higher ones do not exist
  int id = options.domain_id.value_or(0);
  std::string_view text;
  if (const char* variable = std::getenv("ROS_DOMAIN_ID")) text = variable;
  if (!options.domain_id && !text.empty()) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
    if (error != std::errc() || end != text.data() + text.size()) id = -1;
  }
  if (id < 0 || id > kHighest) {
    return Error{kCodeParametersInvalid,
                 "the DDS domain must be 0 to 232, but it is " +
                     (options.domain_id ? std::to_string(id) : "\"" + std::string(text) + "\"")};
  }
  return id;
}

RosDistro ChosenDistro(std::optional<RosDistro> configured) {
  if (configured) return *configured;
  const char* variable = std::getenv("ROS_DISTRO");
  const std::string_view name = variable != nullptr ? variable : "";
  if (name == "galactic") return RosDistro::kGalactic;
  if (name == "humble") return RosDistro::kHumble;
  return RosDistro::kJazzy;
}

Result<TransportProfile> Profile(const DdsOptions& options) {
  return dds::ChosenProfile(options.profile);
}

bool ReachesOtherHosts(const DdsOptions& options) {
  const Result<TransportProfile> profile = Profile(options);
  return !profile || profile.value() == TransportProfile::kLan;
}

Result<std::unique_ptr<Node>> MakeDdsNode(EventLoop& loop, const DdsOptions& options) {
  const Result<int> domain_id = DomainId(options);
  if (!domain_id) return domain_id.error();
  const Result<TransportProfile> profile = Profile(options);
  if (!profile) return profile.error();
  if (options.credentials) {
    constexpr int kHighestSecured = 230;  // accepted by Cyclone's reader of governance documents
    if (domain_id.value() > kHighestSecured) {
      return Error{kCodeParametersInvalid, "DDS Security supports the domains 0 to 230, not " +
                                               std::to_string(domain_id.value())};
    }
    const keys::KeyFolder folder(options.credentials->keys);
    if (auto good = keys::Check(folder, options.credentials->identity); !good) return good.error();
  }
  const bool restarted = std::getenv("MUSHER_FAST_DISCOVERY") != nullptr;
  const bool combined = options.discovery == DiscoveryTiming::kCombined ||
                        options.discovery == DiscoveryTiming::kCombinedLong;
  const bool fast = restarted && combined;
  const DiscoveryTiming discovery = fast ? DiscoveryTiming::kAtOnce : options.discovery;
  const bool unicast = options.unicast || std::getenv("MUSHER_UNICAST") != nullptr;
  const char* uri = std::getenv("CYCLONEDDS_URI");
  const bool own_settings = uri != nullptr && ReplacesProfile(profile.value(), uri);
  std::vector<std::string> outer;
  if (profile.value() == TransportProfile::kLan && !own_settings) {
    outer = OuterInterfacesFor(options, domain_id.value());
  }
  auto participant = dds::OpenParticipant(
      domain_id.value(),
      own_settings ? ""
                   : dds::SettingsXml(profile.value(), options.lease, discovery, unicast, outer,
                                      options.own_networks_only),
      options.credentials, ChosenDistro(options.ros_distro), PeerName(options));
  if (!participant) return participant.error();
  return std::unique_ptr<Node>(std::make_unique<DdsNode>(loop, std::move(participant).value(),
                                                         options.name_space, NodeName(options)));
}

}  // namespace musher::transport
