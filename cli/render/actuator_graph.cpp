#include <map>

#include "musher/cli/render/graph.hpp"

namespace musher::cli {
namespace {

std::map<int, std::vector<const ActuatorConfig*>> ByStage(const MachineConfig& config) {
  std::map<int, std::vector<const ActuatorConfig*>> by_stage;
  for (const ActuatorConfig& a : config.actuators) by_stage[a.stage].push_back(&a);
  return by_stage;
}

}  // namespace

std::string ActuatorsDot(const MachineConfig& config) {
  std::string dot = "digraph \"" + config.name +
                    "\" {\n"
                    "  rankdir=LR;\n"
                    "  node [shape=box, fontname=\"sans-serif\"];\n";
  for (const auto& [stage, actuators] : ByStage(config)) {
    const std::string number = std::to_string(stage);
    dot += "  subgraph cluster_stage_" + number + " {\n    label=\"stage " + number + "\";\n";
    for (const ActuatorConfig* a : actuators) {
      dot += "    \"" + a->name + "\"" +
             (a->critical ? " [penwidth=2, label=\"" + a->name + "\\ncritical\"]" : "") + ";\n";
    }
    dot += "  }\n";
  }
  for (const ActuatorConfig& a : config.actuators) {
    for (const std::string& first : a.after) {
      dot += "  \"" + first + "\" -> \"" + a.name + "\";\n";
    }
    for (const std::string& bound : a.binds_to) {
      dot += "  \"" + bound + "\" -> \"" + a.name + "\" [style=dotted];\n";
    }
  }
  return dot + "}\n";
}

std::string ActuatorsMermaid(const MachineConfig& config) {
  std::string text = "flowchart LR\n";
  // Names are prefixed: Mermaid has words, such as "end", that cannot be ids.
  const auto id = [](const std::string& name) { return "a_" + name; };
  for (const auto& [stage, actuators] : ByStage(config)) {
    const std::string number = std::to_string(stage);
    text += "  subgraph stage_" + number + " [\"stage " + number + "\"]\n";
    for (const ActuatorConfig* a : actuators) {
      text +=
          "    " + id(a->name) + "[\"" + a->name + (a->critical ? "<br/>critical" : "") + "\"]\n";
    }
    text += "  end\n";
  }
  for (const ActuatorConfig& a : config.actuators) {
    for (const std::string& first : a.after) text += "  " + id(first) + " --> " + id(a.name) + "\n";
    for (const std::string& bound : a.binds_to) {
      text += "  " + id(bound) + " -.-> " + id(a.name) + "\n";
    }
  }
  return text;
}

}  // namespace musher::cli
