#include "musher/lifecycle/config/config.hpp"

#include <algorithm>

#include "musher/base/suggest.hpp"
#include "musher/lifecycle/refusal.hpp"

namespace musher {

std::string_view ProtocolName(Protocol protocol) {
  switch (protocol) {
    case Protocol::kCyberdog:
      return "cyberdog";
    case Protocol::kRos2Lifecycle:
      return "ros2_lifecycle";
    case Protocol::kMusher:
      break;
  }
  return "musher";
}

bool HasQuery(Protocol protocol) {
  return protocol != Protocol::kCyberdog;
}

bool RestartConfig::Prevents(int exit_code) const {
  return std::find(prevent_exit_codes.begin(), prevent_exit_codes.end(), exit_code) !=
         prevent_exit_codes.end();
}

void TakeOwnHosts(MachineConfig& config, const std::vector<std::string>& addresses) {
  for (const HostConfig& host : config.hosts) {
    if (std::ranges::count(addresses, host.address) == 0) continue;
    for (ActuatorConfig& actuator : config.actuators) {
      if (actuator.host != host.name) continue;
      actuator.host.clear();
      if (actuator.cwd.empty()) actuator.cwd = "/";  // as where its host starts it
    }
  }
  std::erase_if(config.hosts, [&](const HostConfig& host) {
    return std::ranges::count(addresses, host.address) != 0;
  });
}

std::string HostConfig::Login() const {
  return user.empty() ? address : user + "@" + address;
}

bool ActuatorConfig::Lists(std::string_view state) const {
  return std::find(states.begin(), states.end(), state) != states.end();
}

std::optional<Duration> ActuatorConfig::TimeFor(std::string_view state) const {
  const auto found = std::find(states.begin(), states.end(), state);
  if (found == states.end()) return std::nullopt;
  return times[found - states.begin()];
}

bool CapabilityConfig::RunsIn(std::string_view state) const {
  return std::find(states.begin(), states.end(), state) != states.end();
}

bool CapabilityConfig::Takes(std::string_view actuator) const {
  return std::find(actuators.begin(), actuators.end(), actuator) != actuators.end();
}

std::optional<ActuatorIndex> MachineConfig::IndexOf(std::string_view actuator) const {
  const auto found = std::find_if(actuators.begin(), actuators.end(),
                                  [&](const ActuatorConfig& a) { return a.name == actuator; });
  if (found == actuators.end()) return std::nullopt;
  return ActuatorIndex(static_cast<std::size_t>(found - actuators.begin()));
}

const HostConfig* MachineConfig::HostOf(std::string_view name) const {
  const auto found = std::find_if(hosts.begin(), hosts.end(),
                                  [&](const HostConfig& host) { return host.name == name; });
  return found == hosts.end() ? nullptr : &*found;
}

const CapabilityConfig* MachineConfig::CapabilityOf(std::string_view capability) const {
  const auto found = std::find_if(capabilities.begin(), capabilities.end(),
                                  [&](const CapabilityConfig& c) { return c.name == capability; });
  return found == capabilities.end() ? nullptr : &*found;
}

std::optional<Rank> MachineConfig::RankOf(std::string_view state) const {
  const auto found = ranks.find(State(state));
  if (found == ranks.end()) return std::nullopt;
  return found->second;
}

bool MachineConfig::HasState(std::string_view state) const {
  return std::find(states.begin(), states.end(), state) != states.end();
}

Duration MachineConfig::TimeFor(ActuatorIndex actuator, std::string_view state) const {
  return actuators[actuator].TimeFor(state).value_or(default_time);
}

std::vector<FlowEdge> DefaultFlow(const std::vector<State>& states) {
  std::vector<State> resting;  // all but the steps of a start, Error and TearDown
  const auto listed = [&](std::string_view s) {
    return std::find(states.begin(), states.end(), s) != states.end();
  };
  for (const State& s : states) {
    if (s != kUninitialized && s != kSetUp && s != kSelfCheck && s != kError && s != kTearDown) {
      resting.push_back(s);
    }
  }
  std::vector<FlowEdge> flow;
  const auto add = [&](std::string_view from, std::string_view to) {
    if (listed(from) && listed(to)) flow.push_back({State(from), State(to)});
  };
  for (const State& from : resting) {
    for (const State& to : resting) {
      if (from != to) add(from, to);
    }
    add(from, kError);
    add(from, kTearDown);
  }
  add(kError, kSelfCheck);
  add(kError, kTearDown);
  add(kSelfCheck, kDeActive);
  add(kSelfCheck, kActive);
  add(kSelfCheck, kError);
  add(kSelfCheck, kTearDown);
  return flow;
}

Error UnknownActuator(std::string_view name, const MachineConfig& config) {
  std::vector<std::string> names;
  names.reserve(config.actuators.size());
  for (const ActuatorConfig& actuator : config.actuators) names.push_back(actuator.name);
  const std::string_view word = name.substr(0, kLongestWord);
  // `musher set arm Active`
  if (config.HasState(word))
    return Refused<Refusal::kUnknownActuator>(word, ", but a state: `musher set STATE ACTUATOR`");
  return Refused<Refusal::kUnknownActuator>(word, KnownNames(name, names));
}

}  // namespace musher
