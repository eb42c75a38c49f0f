#include "musher/test/simulation/drawn_config.hpp"

#include <algorithm>
#include <string>

#include "musher/transport/sim/random.hpp"

namespace musher::testing {
namespace {

using transport::sim::Random;

const std::vector<State> kAllStates = {"SetUp",     "TearDown", "SelfCheck", "Active", "DeActive",
                                       "Protected", "LowPower", "OTA",       "Error"};

// Few actuators mostly, sometimes many.
std::size_t DrawSize(Random& dice) {
  const std::uint64_t most = dice.Chance(0.1) ? 32 : (dice.Chance(0.3) ? 12 : 5);
  return 1 + dice.Next() % most;
}

RestartConfig DrawRestart(Random& dice) {
  static constexpr RestartPolicy kPolicies[] = {RestartPolicy::kNo, RestartPolicy::kOnFailure,
                                                RestartPolicy::kAlways};
  RestartConfig restart;
  restart.policy = kPolicies[dice.Next() % 3];
  restart.limit = static_cast<int>(dice.Next() % 4);
  restart.delay = Milliseconds(static_cast<std::int64_t>(dice.Next() % 3) * 100);
  restart.reset_after = std::chrono::seconds(2);
  return restart;
}

ActuatorConfig DrawActuator(const MachineConfig& config, Random& dice) {
  const std::vector<ActuatorConfig>& others = config.actuators;
  ActuatorConfig actuator;
  actuator.name = "a" + std::to_string(others.size());
  for (const State& state : config.states) {
    const bool dispensable = state == kOta || state == kLowPower || state == kProtected;
    if (dispensable && dice.Chance(0.05)) continue;
    actuator.states.push_back(state);
    actuator.times.push_back(dice.Between(Milliseconds(100), Milliseconds(1500)));
  }
  if (dice.Chance(0.8)) actuator.command = {"run", actuator.name};
  if (!others.empty()) {
    const ActuatorConfig& other = others[dice.Next() % others.size()];
    if (dice.Chance(0.3)) actuator.after = {other.name};
    if (dice.Chance(0.15)) actuator.binds_to = {others.front().name};
    actuator.stage = dice.Chance(0.2) ? 2 : others.back().stage;
    for (const std::string& before : actuator.after) {
      actuator.stage = std::max(actuator.stage, others[*config.IndexOf(before)].stage);
    }
  }
  actuator.critical = dice.Chance(0.2);
  if (actuator.critical) actuator.on_lost = dice.Chance(0.8) ? kProtected : kLowPower;
  if (!actuator.critical && dice.Chance(0.1)) actuator.on_lost = kDeActive;
  actuator.restart = DrawRestart(dice);
  if (dice.Chance(0.3)) actuator.checkpoint = Milliseconds(200);
  if (dice.Chance(0.2)) {
    actuator.controller_lost = std::chrono::seconds(1);
    actuator.on_controller_lost = kDeActive;
  }
  return actuator;
}

// With dice of its own, so that robots without one are as they were.
std::optional<PolicyConfig> DrawPolicy(std::uint64_t seed) {
  Random dice(seed * 2 + 0x706f6c6963);
  if (!dice.Chance(0.3)) return std::nullopt;
  PolicyConfig policy;
  if (dice.Chance(0.9)) {
    BatteryPolicy& battery = policy.battery.emplace();
    battery.protected_at = 10 + static_cast<int>(dice.Next() % 50);
    battery.low_power_at = 1 + static_cast<int>(dice.Next() % 9);
    const int room = battery.protected_at - battery.low_power_at;
    battery.hysteresis = static_cast<int>(dice.Next() % static_cast<std::uint64_t>(room) % 6);
  }
  if (dice.Chance(0.9)) {
    LowPowerPolicy& low_power = policy.low_power.emplace();
    low_power.enabled = dice.Chance(0.5);
    low_power.lying_still = dice.Between(Milliseconds(500), std::chrono::seconds(5));
  }
  policy.power.delay = dice.Between(Milliseconds(0), std::chrono::seconds(2));
  policy.power.force_after = policy.power.delay + dice.Between({}, std::chrono::seconds(15));
  return policy;
}

// What other hosts run is not started by the controller.
void StartSomeByHand(MachineConfig& config, std::uint64_t seed) {
  Random dice(seed * 2 + 0x68616e64);
  for (ActuatorConfig& actuator : config.actuators) {
    if (dice.Chance(0.4)) actuator.command.clear();
  }
}

// Takes ways out of the flow, but none to Active, to which people bring the machine back. That a
// fallback or the battery's ceiling is forbidden does not matter.
void LeaveWaysOut(MachineConfig& config, std::uint64_t seed) {
  Random dice(seed * 2 + 0x666c6f77);
  if (!dice.Chance(0.2)) return;
  std::erase_if(config.flow, [&dice](const FlowEdge& edge) {
    return edge.to != kActive && edge.from != kError && dice.Chance(0.4);
  });
}

}  // namespace

MachineConfig DrawConfig(std::uint64_t seed) {
  Random dice(seed * 2);
  MachineConfig config;
  config.name = "drawn";
  config.file = "drawn-" + std::to_string(seed);
  config.hash = "0123456789abcdef";
  config.states = kAllStates;
  config.default_time = Milliseconds(200);
  for (const State& state : kAllStates) {
    if (const auto rank = BuiltInRank(state)) config.ranks[state] = *rank;
  }
  if (dice.Chance(0.1)) {  // one of its own, between DeActive and Protected
    config.states.emplace_back("Parked");
    config.ranks[State("Parked")] = *BuiltInRank(kDeActive);
  }
  config.flow = DefaultFlow(config.states);
  if (config.HasState("Parked")) {
    for (const std::string_view state : {kActive, kProtected, kDeActive, kLowPower, kOta}) {
      config.flow.push_back({State("Parked"), State(state)});
      config.flow.push_back({State(state), State("Parked")});
    }
  }
  if (dice.Chance(0.35)) config.transport = TransportProfile::kLan;
  config.policy = DrawPolicy(seed);
  const std::size_t size = DrawSize(dice);
  while (config.actuators.size() < size) config.actuators.push_back(DrawActuator(config, dice));
  if (config.transport == TransportProfile::kLan) StartSomeByHand(config, seed);
  LeaveWaysOut(config, seed);
  return config;
}

}  // namespace musher::testing
