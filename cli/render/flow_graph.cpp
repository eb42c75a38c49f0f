#include <algorithm>
#include <map>

#include "musher/cli/render/graph.hpp"
#include "musher/lifecycle/config/flow.hpp"

namespace musher::cli {
namespace {

// The machine's states by rank, the most active first, without those that have no rank.
std::map<int, std::vector<State>, std::greater<>> ByRank(const MachineConfig& config) {
  std::map<int, std::vector<State>, std::greater<>> by_rank;
  for (const State& state : config.states) {
    if (const auto rank = config.RankOf(state)) by_rank[*rank].push_back(state);
  }
  return by_rank;
}

bool HasTransition(const MachineConfig& config, const State& from, const State& to) {
  if (from == to) return false;
  const bool keeps_state = to == kSelfCheck && config.RankOf(from) && from != kError;
  return !keeps_state && FlowAllows(config, from, to);
}

}  // namespace

std::vector<FlowTransition> FlowTransitions(const MachineConfig& config) {
  std::vector<FlowTransition> transitions;
  for (std::size_t i = 0; i < config.states.size(); ++i) {
    for (std::size_t k = i + 1; k < config.states.size(); ++k) {
      const State& a = config.states[i];
      const State& b = config.states[k];
      const bool forward = HasTransition(config, a, b);
      const bool back = HasTransition(config, b, a);
      if (forward) transitions.push_back({a, b, back});
      if (back && !forward) transitions.push_back({b, a, false});
    }
  }
  return transitions;
}

std::string FlowDot(const MachineConfig& config) {
  std::string dot = "digraph \"" + config.name +
                    "\" {\n"
                    "  rankdir=TB;\n"
                    "  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n";
  for (const auto& [rank, states] : ByRank(config)) {
    dot += "  { rank=same;";
    for (const State& s : states) {
      dot += " \"" + s + "\" [label=\"" + s + "\\nrank " + std::to_string(rank) + "\"];";
    }
    dot += " }\n";
  }
  for (const State& s : config.states) {
    if (!config.RankOf(s)) dot += "  \"" + s + "\" [style=\"rounded,dashed\"];\n";
  }
  for (const FlowTransition& transition : FlowTransitions(config)) {
    dot += "  \"" + transition.from + "\" -> \"" + transition.to + "\"";
    if (transition.both) dot += " [dir=both]";
    if (transition.to == kTearDown || transition.to == kError) dot += " [color=gray60]";
    dot += ";\n";
  }
  return dot + "}\n";
}

std::string FlowMermaid(const MachineConfig& config) {
  std::string text = "stateDiagram-v2\n";
  for (const State& s : config.states) {
    if (const auto rank = config.RankOf(s)) {
      text += "  " + s + " : " + s + " (rank " + std::to_string(*rank) + ")\n";
    }
  }
  if (config.HasState(kSetUp)) text += "  [*] --> SetUp\n";
  for (const FlowTransition& transition : FlowTransitions(config)) {
    text += "  " + transition.from + " --> " + transition.to + "\n";
    if (transition.both) text += "  " + transition.to + " --> " + transition.from + "\n";
  }
  if (config.HasState(kTearDown)) text += "  TearDown --> [*]\n";
  return text;
}

}  // namespace musher::cli
