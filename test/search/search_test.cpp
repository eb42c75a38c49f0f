// Every order of events, with up to two faults, on a machine of three actuators, from each state to
// each state.

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "musher/test/search/explorer.hpp"
#include "musher/test/search/scenarios.hpp"

namespace musher::search {
namespace {

std::string Environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

class ExhaustiveSearch : public ::testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(ExhaustiveSearch, FindsNothingWrong) {
  const Scenario& scenario = ScenarioNamed(std::get<0>(GetParam()));
  const State from = std::get<1>(GetParam());
  const std::string only = Environment("MUSHER_SEARCH_TARGET");
  const std::string faults = Environment("MUSHER_SEARCH_FAULTS");
  for (const State& to : AllStates()) {
    if (!only.empty() && to != only) continue;
    const Model model(scenario.config, to);
    World root = WorldIn(model, from);
    root.faults_left = faults.empty() ? 1 : std::stoi(faults);
    if (!MayGo(from, to)) continue;
    const Searched searched = SearchAll(model, root);
    const Figures& f = searched.figures;
    std::printf("%-10s %-14s %-10s %9zu %10zu %8zu %7.2f\n", scenario.name.c_str(), from.c_str(),
                to.c_str(), f.nodes, f.transitions, f.leaves, f.seconds);
    if (searched.fault) {
      ADD_FAILURE() << from << " to " << to << "\n"
                    << StoryOf(model, root, searched.fault->path) << searched.fault->path;
    }
  }
}

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const Scenario& s : Scenarios()) names.push_back(s.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Of, ExhaustiveSearch,
                         ::testing::Combine(::testing::ValuesIn(Names()),
                                            ::testing::ValuesIn(AllStates())),
                         [](const auto& which) {
                           return std::get<0>(which.param) + "From" + std::get<1>(which.param);
                         });

}  // namespace
}  // namespace musher::search
