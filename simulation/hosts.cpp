#include "musher/simulation/hosts.hpp"

#include <algorithm>

#include "musher/transport/sim/random.hpp"

namespace musher::simulation {
namespace {

constexpr std::array<std::string_view, 3> kHostNames = {"robot", "dock", "arm"};
constexpr Duration kBootTime =
    std::chrono::seconds(5);  // until the first process of the robot starts
constexpr double kSharedShare = 0.3;

}  // namespace

std::string_view HostName(std::size_t host) {
  return kHostNames[host];
}

Layout SampleLayout(const MachineConfig& config, std::uint64_t seed, bool shared_processes) {
  transport::sim::Random random(seed * 2 + 0x686f7374);
  Layout layout;
  const bool several = config.transport == TransportProfile::kLan;
  const std::size_t hosts = !several ? 1 : (random.Bernoulli(0.4) ? 3 : 2);
  layout.hosts.assign(kHostNames.begin(), kHostNames.begin() + static_cast<std::ptrdiff_t>(hosts));
  layout.controllers = {0, several && random.Bernoulli(0.8) ? std::size_t{1} : 0};
  for (const ActuatorIndex i : config.actuators.Indices()) {
    const bool started_by_hand = config.actuators[i].command.empty();
    layout.host_of.push_back(started_by_hand ? random.Next() % hosts : 0);
    layout.process_of.push_back(i);
    if (!shared_processes || !started_by_hand || i == 0 || !random.Bernoulli(kSharedShare))
      continue;
    const ActuatorIndex first = layout.process_of[ActuatorIndex(random.Next() % i.value())];
    if (config.actuators[first].protocol != Protocol::kMusher) continue;
    layout.process_of[i] = first;
    layout.host_of[i] = layout.host_of[first];
  }
  return layout;
}

Hosts::Hosts(transport::sim::Network& network, const std::vector<std::string>& names)
    : network_(network) {
  for (const std::string& name : names) hosts_.push_back({.name = name, .endpoints = {}});
}

std::string Hosts::Id(std::size_t host) const {
  return hosts_[host].name + "-" + std::to_string(hosts_[host].boot) + "/0";
}

Incarnation Hosts::NewIncarnation(std::size_t host) {
  Host& h = hosts_[host];
  const auto since_boot = (network_.now().time_since_epoch() + h.clock_offset).count();
  h.last_incarnation =
      std::max(h.last_incarnation + 1, Incarnation(static_cast<std::uint64_t>(since_boot)));
  return h.last_incarnation;
}

void Hosts::SetUptime(std::size_t host, Duration uptime) {
  Host& h = hosts_[host];
  h.clock_offset = uptime - network_.now().time_since_epoch();
  h.booted = network_.now() - uptime;
  for (const std::string& endpoint : h.endpoints) {
    network_.SetClockOffset(endpoint, h.clock_offset);
  }
}

void Hosts::Reboot(std::size_t host) {
  Host& h = hosts_[host];
  ++h.boot;
  h.next_pid = 1000;
  h.last_incarnation = 0;
  SetUptime(host, kBootTime);
}

void Hosts::Attach(const std::string& endpoint, std::size_t host) {
  Host& h = hosts_[host];
  if (std::find(h.endpoints.begin(), h.endpoints.end(), endpoint) != h.endpoints.end()) return;
  h.endpoints.push_back(endpoint);
  network_.SetClockOffset(endpoint, h.clock_offset);
  for (const auto& [link, count] : host_blocks_) {
    if (count == 0) continue;
    if (link.first == host) {
      for (const std::string& to : hosts_[link.second].endpoints) SetBlocked(endpoint, to, true);
    }
    if (link.second == host) {
      for (const std::string& from : hosts_[link.first].endpoints) SetBlocked(from, endpoint, true);
    }
  }
}

void Hosts::SetBlocked(const std::string& from, const std::string& to, bool blocked) {
  Link& link = links_[{from, to}];
  link.blocks += blocked ? 1 : -1;
  link.until = link.blocks > 0 ? Time::max() : network_.now();
  if (link.blocks == 0) network_.Free(from, to);
  if (link.blocks == 1 && blocked) network_.Block(from, to);
}

void Hosts::SetHostBlocked(std::size_t from, std::size_t to, bool blocked) {
  int& count = host_blocks_[{from, to}];
  const bool was_blocked = count > 0;
  count += blocked ? 1 : -1;
  if (was_blocked == (count > 0)) return;
  for (const std::string& source : hosts_[from].endpoints) {
    for (const std::string& target : hosts_[to].endpoints) SetBlocked(source, target, blocked);
  }
}

void Hosts::SetCutOff(std::size_t host, bool cut_off) {
  for (std::size_t other = 0; other < hosts_.size(); ++other) {
    if (other == host) continue;
    SetHostBlocked(host, other, cut_off);
    SetHostBlocked(other, host, cut_off);
  }
}

std::optional<Time> Hosts::BlockedUntil(const std::string& from, const std::string& to) const {
  const auto link = links_.find({from, to});
  if (link == links_.end()) return std::nullopt;
  return link->second.until;
}

}  // namespace musher::simulation
