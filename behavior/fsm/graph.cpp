#include "musher/behavior/fsm/graph.hpp"

#include <optional>

namespace musher::fsm {
namespace {

// The place of a chart in the drawing: the prefix of its state ids, its indentation, and the path
// of its present state.
struct Place {
  std::string prefix;
  std::string indent;
  std::string_view present;

  std::string IdOf(std::size_t state) const { return prefix + std::to_string(state); }
  std::string IdOf(StateId state) const { return IdOf(Index(state)); }

  bool IsPresent(const Chart::Node& node) const {
    return present.substr(0, present.find('/')) == node.name;
  }
  // Of the chart inside of a state.
  Place Inside(std::size_t state, const Chart::Node& node) const {
    const std::size_t slash = present.find('/');
    const bool goes_on = IsPresent(node) && slash != std::string_view::npos;
    return {IdOf(state) + "_", indent + "  ", goes_on ? present.substr(slash + 1) : ""};
  }
};

bool IsControl(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

// For a quoted string, which Graphviz searches for its own escapes and for HTML entities.
std::string DotQuoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      (quoted += '\\') += c;
    } else if (c == '&') {
      quoted += "&amp;";
    } else if (c == '\n') {
      quoted += "\\n";
    } else {
      quoted += IsControl(c) ? ' ' : c;
    }
  }
  return quoted + "\"";
}

// Characters with a meaning in Mermaid or HTML become entities, in Mermaid's form.
std::string MermaidText(std::string_view text) {
  constexpr std::string_view kSpecial = "\"#;:<>&%{}\\`";
  std::string escaped;
  for (const char c : text) {
    if (kSpecial.find(c) != std::string_view::npos) {
      escaped += "#" + std::to_string(static_cast<int>(c)) + ";";
    } else {
      escaped += IsControl(c) ? ' ' : c;
    }
  }
  return escaped;
}

std::string DotStyle(const Chart::Node& node, bool present) {
  std::string style;
  if (node.role == Role::kSafe) style += ", shape=octagon, style=filled, color=firebrick";
  if (node.role == Role::kFinal) style += ", peripheries=2";
  if (present) style += node.inside.empty() ? ", fillcolor=gold" : ", fillcolor=lightyellow";
  if (present) style += ", penwidth=2";
  return style;
}

class Dot {
 public:
  std::string Draw(const Chart& chart, std::string_view present) && {
    text_ =
        "digraph " + DotQuoted(chart.name) +
        " {\n"
        "  compound=true;\n"
        "  node [shape=box, style=\"rounded,filled\", fillcolor=white, fontname=\"sans-serif\"];\n"
        "  edge [fontname=\"sans-serif\", fontsize=10];\n";
    DrawInside(chart, {"s", "  ", present});
    return text_ + "}\n";
  }

 private:
  void DrawInside(const Chart& chart, const Place& place) {
    Line(place, place.prefix + "start [shape=point, fillcolor=black, label=\"\"]");
    for (std::size_t i = 0; i < chart.states.size(); ++i) DrawState(chart.states[i], i, place);
    if (Index(chart.start) < chart.states.size()) {
      Arrow(chart, place, place.prefix + "start", {}, chart.start, "");
    }
    for (const ChartTransition& transition : chart.transitions) {
      Arrow(chart, place, Anchor(chart, place, transition.from), transition.from, transition.to,
            transition.when);
    }
  }

  void DrawState(const Chart::Node& node, std::size_t state, const Place& place) {
    const std::string id = place.IdOf(state);
    const std::string style = DotStyle(node, place.IsPresent(node));
    if (node.inside.empty()) {
      Line(place, id + " [label=" + DotQuoted(node.name) + style + "]");
      return;
    }
    text_ += place.indent + "subgraph cluster_" + id + " {\n";
    const Place inside = place.Inside(state, node);
    Line(inside, "graph [label=" + DotQuoted(node.name) +
                     ", fontname=\"sans-serif\", style=\"rounded,filled\"" +
                     (place.IsPresent(node) ? "" : ", fillcolor=white") + style + "]");
    DrawInside(node.inside.front(), inside);
    text_ += place.indent + "}\n";
  }

  // Graphviz draws arrows between nodes only. The arrows of a cluster begin and end at its start
  // state, and are cut at its border.
  static std::string Anchor(const Chart& chart, const Place& place, StateId state) {
    const std::string id = place.IdOf(state);
    return HasInside(chart, state) ? id + "_start" : id;
  }
  static bool HasInside(const Chart& chart, StateId state) {
    return !chart.states[Index(state)].inside.empty();
  }

  void Arrow(const Chart& chart, const Place& place, const std::string& tail,
             std::optional<StateId> from, StateId to, const std::string& when) {
    std::string style;
    if (!when.empty()) style += ", label=" + DotQuoted(when);
    if (from != to) {
      if (from && HasInside(chart, *from)) style += ", ltail=cluster_" + place.IdOf(*from);
      if (HasInside(chart, to)) style += ", lhead=cluster_" + place.IdOf(to);
    }
    Line(place, tail + " -> " + Anchor(chart, place, to) +
                    (style.empty() ? "" : " [" + style.substr(2) + "]"));
  }

  void Line(const Place& place, const std::string& line) { text_ += place.indent + line + ";\n"; }

  std::string text_;
};

class Mermaid {
 public:
  std::string Draw(const Chart& chart, std::string_view present) && {
    text_ = "stateDiagram-v2\n";
    DrawInside(chart, {"s", "  ", present});
    const std::string definitions =
        "  classDef safe stroke:#b22222,stroke-width:2px\n"
        "  classDef present fill:#ffd700,color:#000000\n";
    return text_ + (classes_.empty() ? "" : definitions + classes_);
  }

 private:
  void DrawInside(const Chart& chart, const Place& place) {
    for (std::size_t i = 0; i < chart.states.size(); ++i) DrawState(chart.states[i], i, place);
    if (Index(chart.start) < chart.states.size()) Line(place, "[*] --> " + place.IdOf(chart.start));
    for (const ChartTransition& transition : chart.transitions) {
      Line(place, place.IdOf(transition.from) + " --> " + place.IdOf(transition.to) +
                      (transition.when.empty() ? "" : " : " + MermaidText(transition.when)));
    }
    for (std::size_t i = 0; i < chart.states.size(); ++i) {
      if (chart.states[i].role == Role::kFinal) Line(place, place.IdOf(i) + " --> [*]");
    }
  }

  void DrawState(const Chart::Node& node, std::size_t state, const Place& place) {
    const std::string id = place.IdOf(state);
    const std::string line = "state \"" + MermaidText(node.name) + "\" as " + id;
    if (node.role == Role::kSafe) classes_ += "  class " + id + " safe\n";
    if (place.IsPresent(node)) classes_ += "  class " + id + " present\n";
    if (node.inside.empty()) return Line(place, line);
    Line(place, line + " {");
    DrawInside(node.inside.front(), place.Inside(state, node));
    Line(place, "}");
  }

  void Line(const Place& place, const std::string& line) { text_ += place.indent + line + "\n"; }

  std::string text_;
  std::string classes_;  // at the end, where Mermaid expects them
};

}  // namespace

std::string ToDot(const Chart& chart, std::string_view present) {
  return Dot().Draw(chart, present);
}

std::string ToMermaid(const Chart& chart, std::string_view present) {
  return Mermaid().Draw(chart, present);
}

}  // namespace musher::fsm
