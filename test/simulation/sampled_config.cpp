#include "musher/test/simulation/sampled_config.hpp"

#include <algorithm>
#include <string>

#include "musher/simulation/hosts.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::testing {
namespace {

using transport::sim::Random;

const std::vector<State> kAllStates = {"SetUp",     "TearDown", "SelfCheck", "Active", "DeActive",
                                       "Protected", "LowPower", "OTA",       "Error"};

// Few actuators mostly, sometimes many.
std::size_t SampleSize(Random& random) {
  const std::uint64_t most = random.Bernoulli(0.1) ? 32 : (random.Bernoulli(0.3) ? 12 : 5);
  return 1 + random.Next() % most;
}

RestartConfig SampleRestart(Random& random) {
  static constexpr RestartPolicy kPolicies[] = {RestartPolicy::kNo, RestartPolicy::kOnFailure,
                                                RestartPolicy::kAlways};
  RestartConfig restart;
  restart.policy = kPolicies[random.Next() % 3];
  restart.limit = static_cast<int>(random.Next() % 4);
  restart.delay = Milliseconds(static_cast<std::int64_t>(random.Next() % 3) * 100);
  restart.reset_after = std::chrono::seconds(2);
  return restart;
}

ActuatorConfig SampleActuator(const MachineConfig& config, Random& random) {
  const PerActuator<ActuatorConfig>& others = config.actuators;
  ActuatorConfig actuator;
  actuator.name = "a" + std::to_string(others.size());
  for (const State& state : config.states) {
    const bool dispensable = state == kOta || state == kLowPower || state == kProtected;
    if (dispensable && random.Bernoulli(0.05)) continue;
    actuator.states.push_back(state);
    actuator.times.push_back(random.Between(Milliseconds(100), Milliseconds(1500)));
  }
  if (random.Bernoulli(0.8)) actuator.command = {"run", actuator.name};
  if (!others.empty()) {
    const ActuatorConfig& other = others[ActuatorIndex(random.Next() % others.size())];
    if (random.Bernoulli(0.3)) actuator.after = {other.name};
    if (random.Bernoulli(0.15)) actuator.binds_to = {others[0].name};
    actuator.stage = random.Bernoulli(0.2) ? 2 : others.back().stage;
    for (const std::string& before : actuator.after) {
      actuator.stage = std::max(actuator.stage, others[*config.IndexOf(before)].stage);
    }
  }
  actuator.critical = random.Bernoulli(0.2);
  if (actuator.critical) actuator.on_lost = random.Bernoulli(0.8) ? kProtected : kLowPower;
  if (!actuator.critical && random.Bernoulli(0.1)) actuator.on_lost = kDeActive;
  actuator.restart = SampleRestart(random);
  if (random.Bernoulli(0.3)) actuator.checkpoint = Milliseconds(200);
  if (random.Bernoulli(0.2)) {
    actuator.controller_lost = std::chrono::seconds(1);
    actuator.on_controller_lost = kDeActive;
  }
  return actuator;
}

// Has a random generator of its own, so that robots without a policy do not depend on it.
std::optional<PolicyConfig> SamplePolicy(std::uint64_t seed) {
  Random random(seed * 2 + 0x706f6c6963);
  if (!random.Bernoulli(0.3)) return std::nullopt;
  PolicyConfig policy;
  if (random.Bernoulli(0.9)) {
    BatteryPolicy& battery = policy.battery.emplace();
    battery.protected_at = 10 + static_cast<int>(random.Next() % 50);
    battery.low_power_at = 1 + static_cast<int>(random.Next() % 9);
    const int room = battery.protected_at - battery.low_power_at;
    battery.hysteresis = static_cast<int>(random.Next() % static_cast<std::uint64_t>(room) % 6);
    Random times(seed * 2 + 0x7175696574);
    battery.tear_down_after = times.Between({}, std::chrono::seconds(4));
    battery.raise_after = times.Between({}, std::chrono::seconds(6));
  }
  if (random.Bernoulli(0.9)) {
    LowPowerPolicy& low_power = policy.low_power.emplace();
    low_power.motion_ids = {0, 101};
    low_power.enabled = random.Bernoulli(0.5);
    low_power.lying_still = random.Between(Milliseconds(500), std::chrono::seconds(5));
  }
  policy.power.delay = random.Between(Milliseconds(0), std::chrono::seconds(2));
  const bool announced = policy.power.delay.count() % 3 == 0;  // without another random number
  if (announced) policy.empty_battery_delay = policy.power.delay;
  policy.power.force_after = policy.power.delay + random.Between({}, std::chrono::seconds(15));
  return policy;
}

// Some robots have a state of their own in which they are as active as in Active.
void AddDancing(MachineConfig& config, std::uint64_t seed) {
  Random random(seed * 2 + 0x64616e6365);
  if (!random.Bernoulli(0.1)) return;
  config.states.emplace_back("Dancing");
  config.ranks[State("Dancing")] = *BuiltInRank(kActive);
}

// The controller does not start what runs on other hosts.
void StartSomeByHand(MachineConfig& config, std::uint64_t seed) {
  Random random(seed * 2 + 0x68616e64);
  for (ActuatorConfig& actuator : config.actuators) {
    if (random.Bernoulli(0.4)) actuator.command.clear();
  }
}

// Removes transitions from the flow, but none to Active, to which the operator recovers the
// machine. A fallback or the battery's ceiling may be forbidden by that.
void RemoveTransitions(MachineConfig& config, std::uint64_t seed) {
  Random random(seed * 2 + 0x666c6f77);
  if (!random.Bernoulli(0.2)) return;
  std::erase_if(config.flow, [&random](const FlowEdge& edge) {
    return edge.to != kActive && edge.from != kError && random.Bernoulli(0.4);
  });
}

// Some robots need permits to move, and the policies of some follow /clock. Scenarios use that
// where they have an injected event of it.
void SamplePermitAndClock(MachineConfig& config, std::uint64_t seed) {
  Random random(seed * 2 + 0x7065726d6974);
  if (random.Bernoulli(0.25)) {
    config.permit = random.Between(Milliseconds(200), Milliseconds(1000));
  }
  if (config.policy && random.Bernoulli(0.5)) config.clock = ClockSource::kTopic;
}

}  // namespace

MachineConfig SampleConfig(std::uint64_t seed) {
  Random random(seed * 2);
  MachineConfig config;
  config.name = "sampled";
  config.file = "sampled-" + std::to_string(seed);
  config.hash = "0123456789abcdef";
  config.states = kAllStates;
  config.default_time = Milliseconds(200);
  for (const State& state : kAllStates) {
    if (const auto rank = BuiltInRank(state)) config.ranks[state] = *rank;
  }
  if (random.Bernoulli(0.1)) {  // one of its own, between DeActive and Protected
    config.states.emplace_back("Parked");
    config.ranks[State("Parked")] = *BuiltInRank(kDeActive);
  }
  AddDancing(config, seed);
  config.flow = DefaultFlow(config.states);
  if (config.HasState("Parked")) {
    for (const std::string_view state : {kActive, kProtected, kDeActive, kLowPower, kOta}) {
      config.flow.push_back({State("Parked"), State(state)});
      config.flow.push_back({State(state), State("Parked")});
    }
  }
  if (random.Bernoulli(0.35)) config.transport = TransportProfile::kLan;
  config.policy = SamplePolicy(seed);
  const std::size_t size = SampleSize(random);
  while (config.actuators.size() < size) config.actuators.push_back(SampleActuator(config, random));
  if (config.transport == TransportProfile::kLan) StartSomeByHand(config, seed);
  RemoveTransitions(config, seed);
  SamplePermitAndClock(config, seed);
  return config;
}

MachineConfig SampleConfigWithUnits(std::uint64_t seed) {
  Random random(seed * 2 + 0x756e6974);
  MachineConfig config = SampleConfig(seed);
  config.transport = TransportProfile::kLan;
  const std::vector<std::string> hosts = simulation::SampleLayout(config, seed, false).hosts;
  for (std::size_t i = 1; i < hosts.size(); ++i) {
    HostConfig& host = config.hosts.emplace_back();
    host.name = host.address = hosts[i];
  }
  for (ActuatorConfig& actuator : config.actuators) {
    if (random.Bernoulli(0.4)) continue;
    actuator.command = {"run", actuator.name};
    actuator.host = config.hosts[random.Next() % config.hosts.size()].name;
    actuator.times.front() += std::chrono::seconds(3);  // of SetUp: its host has to be reached
  }
  config.own_units = random.Bernoulli(0.5);
  return config;
}

MachineConfig SampleConfigWithStandby(std::uint64_t seed) {
  Random random(seed * 2 + 0x7374616e6462);
  MachineConfig config = SampleConfig(seed);
  config.transport = TransportProfile::kLan;
  config.failover = random.Between(std::chrono::seconds(3), std::chrono::seconds(6));
  for (const std::string& name : simulation::SampleLayout(config, seed, false).hosts) {
    HostConfig& host = config.hosts.emplace_back();
    host.name = host.address = name;
  }
  for (ActuatorConfig& actuator : config.actuators) {
    if (actuator.protocol != Protocol::kMusher || random.Bernoulli(0.3)) {
      actuator.command.clear();
      continue;
    }
    actuator.command = {"run", actuator.name};
    actuator.host = config.hosts[random.Next() % config.hosts.size()].name;
    actuator.times.front() += std::chrono::seconds(3);  // of SetUp: its host has to be reached
  }
  config.own_units = random.Bernoulli(0.3);
  return config;
}

}  // namespace musher::testing
