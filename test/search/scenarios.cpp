#include "musher/test/search/scenarios.hpp"

#include <algorithm>
#include <cassert>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::search {
namespace {

using testing::ActuatorNamed;
using testing::MachineOf;

constexpr std::size_t kActuators = 3;

// Actuators that are overdue one after the other.
MachineConfig Staggered() {
  MachineConfig config = MachineOf(kActuators);
  for (const ActuatorIndex i : config.actuators.Indices()) {
    auto& times = config.actuators[i].times;
    times.assign(times.size(), Milliseconds(100 + 10 * static_cast<int>(i.value())));
  }
  return config;
}

MachineConfig WithCriticalB() {
  MachineConfig config = MachineOf(kActuators);
  ActuatorNamed(config, "b").critical = true;
  ActuatorNamed(config, "b").on_lost = "Protected";
  return config;
}

// It may run without an actuator that is out of restarts.
MachineConfig WithRestarts() {
  MachineConfig config = testing::Ours(kActuators);
  for (ActuatorConfig& actuator : config.actuators) actuator.on_lost = "Active";
  return config;
}

MachineConfig WithAnotherHost() {
  MachineConfig config = testing::OursWithCriticalB(2);
  ActuatorNamed(config, "a").on_lost = "Active";
  ActuatorNamed(config, "b").host = "board";
  config.hosts.emplace_back().name = "board";
  config.transport = TransportProfile::kLan;
  return config;
}

bool IsStable(const State& state) {
  static const std::vector<State> places = {"Active", "Protected", "DeActive", "LowPower", "OTA"};
  return std::find(places.begin(), places.end(), state) != places.end();
}

}  // namespace

const std::vector<Scenario>& Scenarios() {
  static const std::vector<Scenario> all = {
      {"Parallel", MachineOf(kActuators)}, {"Chain", testing::Chain(), 2},
      {"Critical", WithCriticalB()},       {"Staggered", Staggered()},
      {"Restarted", WithRestarts()},
  };
  return all;
}

const Scenario& EqualRanks() {
  static const Scenario equal_ranks = {"EqualRanks", testing::WithDancing(MachineOf(kActuators))};
  return equal_ranks;
}

const Scenario& TwoHosts() {
  static const Scenario two_hosts = {"TwoHosts", WithAnotherHost()};
  return two_hosts;
}

const Scenario& ScenarioNamed(const std::string& name) {
  const auto found = std::find_if(Scenarios().begin(), Scenarios().end(),
                                  [&](const Scenario& s) { return s.name == name; });
  assert(found != Scenarios().end());
  return *found;
}

std::vector<State> AllStates() {
  std::vector<State> states;
  for (const std::string_view state : BuiltInStates()) states.emplace_back(state);
  return states;
}

bool IsPermitted(const State& from, const State& to) {
  if (to == "Uninitialized" || to == "SetUp" || from == "TearDown") return false;
  if (to == "TearDown") return true;
  if (from == "Uninitialized") return false;
  if (IsStable(from)) return true;  // to each other, to Error, and a self-check
  if (to == "SelfCheck" || to == from) return true;
  if (from == "SelfCheck") return to == "Active" || to == "DeActive" || to == "Error";
  return false;
}

World WorldIn(const Model& model, const State& state) {
  World world = NewWorld(model);
  Notes notes;
  const bool in_start = state == "Uninitialized" || state == "SetUp";
  Begin(model, world, in_start, notes);
  if (state != "Uninitialized") RunUntilStable(model, world, notes);
  std::vector<State> path;
  if (state == "SelfCheck") path = {"Error", "SelfCheck"};
  if (!in_start && path.empty() && state != "Active") path = {state};
  for (const State& next : path) {
    RequestSwitch(model, world, next, notes);
    RunUntilStable(model, world, notes);
  }
  assert(notes.violations.empty());
  assert(world.machine.state == state);
  world.requests.clear();
  world.from = state;
  world.at_start = true;
  return world;
}

World WorldInStart(const Model& model) {
  World world = NewWorld(model);
  Notes notes;
  Begin(model, world, false, notes);
  while (!world.machine.current || world.machine.current->purpose != Purpose::kStartUpActivate) {
    Make(model, world, Choices(model, world).front(), notes);
  }
  assert(notes.violations.empty());
  world.from = State(kSelfCheck);
  return world;
}

}  // namespace musher::search
