#include <algorithm>
#include <map>

#include "musher/controller/cli/render/graph.hpp"
#include "musher/lifecycle/flow.hpp"

namespace musher::cli {
namespace {

// States of the machine by rank, the most active first; those without a rank come with none.
std::map<int, std::vector<State>, std::greater<>> ByRank(const MachineConfig& config) {
  std::map<int, std::vector<State>, std::greater<>> by_rank;
  for (const State& state : config.states) {
    if (const auto rank = config.RankOf(state)) by_rank[*rank].push_back(state);
  }
  return by_rank;
}

bool HasWay(const MachineConfig& config, const State& from, const State& to) {
  if (from == to) return false;
  const bool keeps_state = to == kSelfCheck && config.RankOf(from) && from != kError;
  return !keeps_state && FlowAllows(config, from, to);
}

}  // namespace

std::vector<FlowWay> FlowWays(const MachineConfig& config) {
  std::vector<FlowWay> ways;
  for (std::size_t i = 0; i < config.states.size(); ++i) {
    for (std::size_t k = i + 1; k < config.states.size(); ++k) {
      const State& a = config.states[i];
      const State& b = config.states[k];
      const bool there = HasWay(config, a, b);
      const bool back = HasWay(config, b, a);
      if (there) ways.push_back({a, b, back});
      if (back && !there) ways.push_back({b, a, false});
    }
  }
  return ways;
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
  for (const FlowWay& way : FlowWays(config)) {
    dot += "  \"" + way.from + "\" -> \"" + way.to + "\"";
    if (way.both) dot += " [dir=both]";
    if (way.to == kTearDown || way.to == kError) dot += " [color=gray60]";
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
  for (const FlowWay& way : FlowWays(config)) {
    text += "  " + way.from + " --> " + way.to + "\n";
    if (way.both) text += "  " + way.to + " --> " + way.from + "\n";
  }
  if (config.HasState(kTearDown)) text += "  TearDown --> [*]\n";
  return text;
}

}  // namespace musher::cli
