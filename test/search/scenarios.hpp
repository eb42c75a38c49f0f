#pragma once
// What is searched: a few small machines, each from every state to every state.

#include <string>
#include <vector>

#include "musher/search/world.hpp"

namespace musher::search {

struct Scenario {
  std::string name;
  MachineConfig config;
  int faults = 1;  // at most; the gate has one
};

const std::vector<Scenario>& Scenarios();
// With Dancing, a state of its own that is as active as Active.
const Scenario& EqualRanks();
// a runs on the controller's host and b, which is critical, on another one.
const Scenario& TwoHosts();
const Scenario& ScenarioNamed(const std::string& name);

// Every state of the machine, in CyberDog's order.
std::vector<State> AllStates();

// Whether the default flow permits the transition, written independently of the code that is
// searched.
bool IsPermitted(const State& from, const State& to);

// The machine in this state, without messages under way and without faults.
World WorldIn(const Model& model, const State& state);
// The machine while its start leads from SelfCheck to Active.
World WorldInStart(const Model& model);

}  // namespace musher::search
