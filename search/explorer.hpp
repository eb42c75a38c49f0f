#pragma once
// The search: breadth first, so that the scenario of a violation is as short as possible.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/search/world.hpp"

namespace musher::search {

struct Figures {
  std::size_t pairs = 0;
  std::size_t nodes = 0;
  std::size_t transitions = 0;
  std::size_t leaves = 0;  // where nothing is left to happen
  double seconds = 0;

  Figures& operator+=(const Figures& other);
};

// The violations in a node, and the path to it, which replays the scenario.
struct Fault {
  std::vector<std::string> violations;
  std::string path;  // "0.3.1": the index in Choices() at each node
};

struct Searched {
  Figures figures;
  std::optional<Fault> fault;
};

// Searches everything that can follow from `root`, up to the first violation.
Searched SearchAll(const Model& model, const World& root);

// The events on this path and the violations at its end, in sentences.
std::string ScenarioOf(const Model& model, const World& root, const std::string& path);

}  // namespace musher::search
