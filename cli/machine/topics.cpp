#include "musher/cli/machine/topics.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "musher/base/suggest.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

// Discovery reports the endpoints of running processes within some 10 ms of each other.
constexpr Duration kQuietDiscovery = Milliseconds(300);

}  // namespace

Result<std::unique_ptr<Topics>> Topics::Begin(Link& link, Events events) {
  std::unique_ptr<Topics> topics(new Topics(link, std::move(events)));
  auto watch = transport::WatchTopics(
      link.node(),
      [self = topics.get()](const transport::DiscoveredEndpoint& endpoint) {
        self->changed_ |= self->table_.OnFound(endpoint);
        if (self->events_.on_found) self->events_.on_found(endpoint);
      },
      [self = topics.get()](transport::EndpointId id) {
        self->table_.OnLost(id);
        if (self->events_.on_lost) self->events_.on_lost(id);
      });
  if (!watch) return watch.error();
  topics->watch_ = std::move(watch).value();
  return topics;
}

void Topics::AwaitAll(Duration timeout) {
  const Time end = link_.loop().Now() + timeout;
  for (Duration left = timeout; left > Duration{} && !link_.interrupted();
       left = end - link_.loop().Now()) {
    changed_ = false;
    const bool any = !table_.List().empty();
    if (!link_.RunUntil([this] { return changed_; }, any ? std::min(left, kQuietDiscovery) : left))
      return;
  }
}

std::optional<Failure> Topics::Await(const std::string& topic) {
  const auto found = [&] { return !table_.EndpointsOf(topic).empty(); };
  if (link_.RunUntil(found, link_.discovery())) return std::nullopt;
  if (link_.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  std::vector<std::string> names;
  for (const view::ListedTopic& one : table_.List()) {
    if (names.empty() || names.back() != one.name) names.push_back(one.name);
  }
  if (!names.empty()) {
    return Failure{ExitCode::kUsage, {kCodeParametersInvalid, NoSuch("topic", topic, names)}};
  }
  return NoTopics();
}

Failure Topics::NoTopics() {
  return {
      ExitCode::kNotDone,
      {kCodeNetError, fmt::format("no process of DDS domain {} has topics: start the robot, or set "
                                  "ROS_DOMAIN_ID; --transport lan searches other hosts",
                                  transport::DomainId({}).value())}};
}

std::vector<Topics::Place> Topics::PlacesOf(
    const std::vector<transport::DiscoveredEndpoint>& endpoints) const {
  const std::vector<transport::PeerInfo> peers = link_.node().Peers();
  std::vector<Place> places;
  places.reserve(endpoints.size());
  for (const transport::DiscoveredEndpoint& endpoint : endpoints) {
    Place& place = places.emplace_back();
    place.node = nodes_.NodeOf(endpoint.id);
    const auto peer = std::find_if(peers.begin(), peers.end(),
                                   [&](const auto& one) { return one.id == endpoint.participant; });
    if (peer == peers.end()) continue;
    place.pid = peer->pid;
    place.host = peer->host;
  }
  return places;
}

}  // namespace musher::cli
