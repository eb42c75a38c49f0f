#pragma once
// What is searched: a few small machines, each from every state that it can be in to every state.

#include <string>
#include <vector>

#include "musher/test/search/world.hpp"

namespace musher::search {

struct Scenario {
  std::string name;
  MachineConfig config;
  int faults = 1;  // up to so many in the gate: all together takes about a minute and a half
};

const std::vector<Scenario>& Scenarios();
const Scenario& ScenarioNamed(const std::string& name);

// Every state of the machine, in CyberDog's order.
std::vector<State> AllStates();

// Where the flow leads from `from`, as the contract has it - told here once more, in other words
// than in the rules that are searched.
bool MayGo(const State& from, const State& to);

// The machine in this state, nothing on its way, nothing wrong.
World WorldIn(const Model& model, const State& state);

}  // namespace musher::search
