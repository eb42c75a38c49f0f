#pragma once
// The search: breadth first, so that the scenario of a fault is as short as it can be.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/test/search/world.hpp"

namespace musher::search {

struct Figures {
  std::size_t pairs = 0;
  std::size_t nodes = 0;
  std::size_t transitions = 0;
  std::size_t leaves = 0;  // where nothing is left to happen
  double seconds = 0;

  Figures& operator+=(const Figures& other);
};

// A way to something that must not be: by it the scenario can be told again.
struct Fault {
  std::vector<std::string> wrong;
  std::string path;  // "0.3.1": which of Choices() was made in each node
};

struct Searched {
  Figures figures;
  std::optional<Fault> fault;
};

// All that can come of `root`, up to the first thing that is wrong.
Searched SearchAll(const Model& model, const World& root);

// What happens on this path, and what is wrong there, in sentences.
std::string ScenarioOf(const Model& model, const World& root, const std::string& path);

}  // namespace musher::search
