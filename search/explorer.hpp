#pragma once
// The search: breadth first, so that the scenario of a violation is as short as possible, or depth
// first, which keeps no more than the nodes of one path beside the fingerprints of all.

#include <atomic>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "musher/search/world.hpp"

namespace musher::search {

struct Figures {
  std::size_t pairs = 0;
  std::size_t nodes = 0;
  std::size_t transitions = 0;
  std::size_t leaves = 0;  // where nothing is left to happen; as many without a reduction
  double seconds = 0;

  Figures& operator+=(const Figures& other);
};

// The violations in a node, and the path to it, which replays the scenario.
struct Fault {
  std::vector<std::string> violations;
  std::string path;  // "0.3.1": the index in Choices() at each node
  // The last choices of the path lead back to where they began, and nothing but a fault leads out
  // of there: the machine never comes to rest.
  bool repeats = false;

  std::size_t Choices() const;  // of the path
};

struct Searched {
  Figures figures;
  std::optional<Fault> fault;
  bool finished = true;  // false: a limit has ended it
  // Depth first alone: of each rule of the user, in the nodes in which nothing is left to happen.
  std::vector<RuleCoverage> rule_coverage = {};
  // The same of each one with a time, in all transitions.
  std::vector<TimedRuleCoverage> timed_coverage = {};
};

// What other threads set while a search runs.
struct SearchLimits {
  std::atomic<bool> stop = false;
  // Only scenarios with fewer choices than this are of interest.
  std::atomic<std::size_t> below = std::numeric_limits<std::size_t>::max();
  std::atomic<std::size_t> nodes = 0;  // of all searches with these limits
};

// Searches everything that can follow from `root`, up to the first violation. Threads: several
// searches may run at once, with the same limits.
Searched SearchAll(const Model& model, const World& root, SearchLimits* limits = nullptr);

// The same nodes, depth first: the scenario of a violation need not be the shortest. Only this one
// finds where the machine never comes to rest.
Searched SearchDepthFirst(const Model& model, const World& root, SearchLimits& limits);

// One choice of a path.
struct PathStep {
  std::vector<std::string> sentences;  // the first one names the choice
  World world;                         // after it
  bool is_missing = false;             // there is no such choice; the last step then
};

// The choices of a path, and what they violate, which is added to `violations`.
std::vector<PathStep> StepsOf(const Model& model, const World& root, const std::string& path,
                              std::vector<std::string>& violations);

// The events on this path and the violations at its end, in sentences.
std::string ScenarioOf(const Model& model, const World& root, const std::string& path);

}  // namespace musher::search
