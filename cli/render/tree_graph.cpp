#include <fmt/format.h>

#include "musher/cli/console/console.hpp"
#include "musher/cli/render/tree.hpp"
#include "musher/cli/render/tree_nodes.hpp"

namespace musher::cli {
namespace {

std::string_view ColourOf(std::uint8_t status) {
  switch (status) {
    case msg::TreeState::kRunning:
      return "gold";
    case msg::TreeState::kSuccess:
      return "palegreen";
    case msg::TreeState::kFailure:
      return "lightcoral";
    case msg::TreeState::kSkipped:
      return "gray85";
    default:
      return "white";
  }
}

std::string_view ShapeOf(const std::string& kind) {
  if (kind == "Condition") return "shape=ellipse, style=filled";
  if (kind == "Decorator") return "shape=diamond, style=filled";
  if (kind == "Control") return "shape=box, style=\"rounded,filled\"";
  if (kind == "SubTree") return "shape=folder, style=filled";
  return "shape=box, style=filled";
}

// For texts between quotation marks of DOT; Graphviz reads "&amp;" as an entity.
std::string DotText(const std::string& text) {
  std::string escaped;
  for (const char c : Printable(text)) {
    if (c == '"' || c == '\\') escaped += '\\';
    escaped += c == '&' ? std::string("&amp;") : std::string(1, c);
  }
  return escaped;
}

std::string MermaidText(const std::string& text) {
  std::string escaped;
  for (const char c : Printable(text)) {
    switch (c) {
      case '"':
        escaped += "#quot;";
        break;
      case '#':
        escaped += "#35;";
        break;
      case '<':
        escaped += "#lt;";
        break;
      case '>':
        escaped += "#gt;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

// "12.5 s, 3 runs"; empty: it has not run.
std::string TimesOf(const msg::TreeNode& node) {
  if (node.runs == 0) return "";
  return fmt::format("{:.3g} s, {} run{}", node.spent_s, node.runs, node.runs == 1 ? "" : "s");
}

}  // namespace

std::string TreeDot(const std::string& name, const msg::GetTree::Response& report) {
  std::string dot = "digraph \"" + DotText(name) +
                    "\" {\n"
                    "  ordering=out;\n"
                    "  node [fontname=\"sans-serif\"];\n";
  for (std::size_t id = 0; id < report.nodes.size(); ++id) {
    const msg::TreeNode& node = report.nodes[id];
    std::string label = DotText(node.name);
    for (const std::string& line : {TypeText(node), TimesOf(node)}) {
      if (!line.empty()) label += "\\n" + DotText(line);
    }
    dot += fmt::format("  n{} [label=\"{}\", {}, fillcolor={}];\n", id, label, ShapeOf(node.kind),
                       ColourOf(StatusOf(report.state, id)));
    if (const auto parent = ParentOf(report.nodes, id)) {
      dot += fmt::format("  n{} -> n{};\n", *parent, id);
    }
  }
  return dot + "}\n";
}

std::string TreeMermaid(const msg::GetTree::Response& report) {
  std::string text = "flowchart TD\n";
  for (std::size_t id = 0; id < report.nodes.size(); ++id) {
    const msg::TreeNode& node = report.nodes[id];
    std::string label = MermaidText(node.name);
    for (const std::string& line : {TypeText(node), TimesOf(node)}) {
      if (!line.empty()) label += "<br/>" + MermaidText(line);
    }
    text += fmt::format("  n{}[\"{}\"]\n", id, label);
    const std::string_view colour = ColourOf(StatusOf(report.state, id));
    if (colour != "white") text += fmt::format("  style n{} fill:{}\n", id, colour);
    if (const auto parent = ParentOf(report.nodes, id)) {
      text += fmt::format("  n{} --> n{}\n", *parent, id);
    }
  }
  return text;
}

}  // namespace musher::cli
