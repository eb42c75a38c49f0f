// The picture of a tree.

#include "musher/behavior/tree/tree.hpp"

namespace musher::tree {
namespace {

std::string DotEscaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      (escaped += '\\') += c;
    } else if (c == '&') {
      escaped += "&amp;";
    } else {
      escaped += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  }
  return escaped;
}

std::string_view Shape(NodeKind kind) {
  switch (kind) {
    case NodeKind::kAction:
      return "box";
    case NodeKind::kCondition:
      return "ellipse";
    case NodeKind::kDecorator:
      return "diamond";
    case NodeKind::kControl:
      return "box, style=\"rounded,filled\"";
    case NodeKind::kSubtree:
      return "folder";
  }
  return "box";
}

std::string_view Colour(Status status) {
  switch (status) {
    case Status::kRunning:
      return "gold";
    case Status::kSuccess:
      return "palegreen";
    case Status::kFailure:
      return "lightcoral";
    default:
      return "white";
  }
}

}  // namespace

std::string ToDot(const Tree& tree) {
  std::string text = "digraph \"" + DotEscaped(tree.name()) +
                     "\" {\n"
                     "  ordering=out;\n"
                     "  node [shape=box, style=filled, fontname=\"sans-serif\"];\n";
  for (NodeId id = 0; id < tree.size(); ++id) {
    const NodeInfo& info = tree.info(id);
    const std::string kind = info.name == info.id ? "" : "\\n" + DotEscaped(info.id);
    text += "  n" + std::to_string(id) + " [label=\"" + DotEscaped(info.name) + kind +
            "\", shape=" + std::string(Shape(info.kind)) +
            ", fillcolor=" + std::string(Colour(tree.status(id))) + "];\n";
    if (info.parent != kNoNode) {
      text += "  n" + std::to_string(info.parent) + " -> n" + std::to_string(id) + ";\n";
    }
  }
  return text + "}\n";
}

}  // namespace musher::tree
