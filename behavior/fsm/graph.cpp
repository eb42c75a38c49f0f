#include "musher/behavior/fsm/graph.hpp"

#include <optional>
#include <set>
#include <vector>

#include "musher/behavior/fsm/reach.hpp"

namespace musher::fsm {
namespace {

// The paths of the present states, of a path as Machine::Path() gives it: "SHOW/(WAVE|SMILE)" has
// three.
void AddPresent(std::string_view path, const std::string& prefix, std::set<std::string>& present) {
  if (path.empty()) return;
  if (path.front() == '(' && path.back() == ')') {
    path = path.substr(1, path.size() - 2);
    int depth = 0;
    std::size_t begin = 0;
    for (std::size_t i = 0; i <= path.size(); ++i) {
      if (i < path.size() && path[i] == '(') ++depth;
      if (i < path.size() && path[i] == ')') --depth;
      if (i < path.size() && (path[i] != '|' || depth > 0)) continue;
      AddPresent(path.substr(begin, i - begin), prefix, present);
      begin = i + 1;
    }
    return;
  }
  const std::size_t slash = path.find('/');
  const std::string state = prefix + std::string(path.substr(0, slash));
  present.insert(state);
  if (slash != std::string_view::npos) AddPresent(path.substr(slash + 1), state + "/", present);
}

// The place of a chart in the drawing: the prefix of its state ids, its indentation, and the path
// of the state around it.
struct Place {
  std::string prefix;
  std::string indent;
  std::string path{};

  std::string IdOf(std::size_t state) const { return prefix + std::to_string(state); }
  std::string IdOf(StateId state) const { return IdOf(Index(state)); }
  std::string PathOf(const Chart::Node& node) const { return path + node.name; }

  // The place of the chart with this number inside a state.
  Place Inside(std::size_t state, const Chart::Node& node, std::size_t number) const {
    const std::string region = number == 0 ? "" : "r" + std::to_string(number) + "_";
    return {IdOf(state) + "_" + region, indent + "  ", PathOf(node) + "/"};
  }
};

// The states of a transition, both in the drawing.
struct Ends {
  std::string from;  // id
  std::string to;
  bool from_holds = false;  // a machine
  bool to_holds = false;
};

std::string IdOf(const std::vector<ChartState>& states) {
  Place place{"s", ""};
  for (std::size_t i = 0; i + 1 < states.size(); ++i) {
    const auto& node = states[i].chart->states[Index(states[i].state)];
    place = place.Inside(Index(states[i].state), node,
                         static_cast<std::size_t>(states[i + 1].chart - node.inside.data()));
  }
  return place.IdOf(states.back().state);
}

bool HoldsMachine(const Chart& chart, StateId state) {
  return !chart.states[Index(state)].inside.empty();
}

// None: the target is not in the drawing, which is of an inner machine alone.
std::optional<Ends> EndsOf(const Chart& outermost, const Chart& chart, const Place& place,
                           const ChartTransition& transition) {
  const std::string from = place.IdOf(transition.from);
  const bool from_holds = HoldsMachine(chart, transition.from);
  if (transition.target.empty()) {
    return Ends{from, place.IdOf(transition.to), from_holds, HoldsMachine(chart, transition.to)};
  }
  const std::vector<ChartState> to = FindPath(outermost, transition.target);
  if (to.empty()) return std::nullopt;
  return Ends{from, IdOf(to), from_holds, HoldsMachine(*to.back().chart, to.back().state)};
}

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

// "IDLE", and "photo / defer" below for each event that the state defers.
std::string LabelOf(const Chart::Node& node, std::string_view line_end) {
  std::string label = node.name;
  for (const std::string& event : node.defers) {
    label += std::string(line_end) + event + " / defer";
  }
  return label;
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
  Dot(const Chart& outermost, std::string_view present) : outermost_(outermost) {
    AddPresent(present, "", present_);
  }

  std::string Draw() && {
    text_ =
        "digraph " + DotQuoted(outermost_.name) +
        " {\n"
        "  compound=true;\n"
        "  node [shape=box, style=\"rounded,filled\", fillcolor=white, fontname=\"sans-serif\"];\n"
        "  edge [fontname=\"sans-serif\", fontsize=10];\n";
    DrawInside(outermost_, {"s", "  "});
    for (const std::string& line : between_) text_ += "  " + line + ";\n";
    return text_ + "}\n";
  }

 private:
  void DrawInside(const Chart& chart, const Place& place) {
    Line(place, place.prefix + "start [shape=point, fillcolor=black, label=\"\"]");
    for (std::size_t i = 0; i < chart.states.size(); ++i) DrawState(chart.states[i], i, place);
    if (Index(chart.start) < chart.states.size()) {
      Line(place, Arrow({place.prefix + "start", place.IdOf(chart.start), false,
                         HoldsMachine(chart, chart.start)},
                        "", Into::kStart));
    }
    for (const ChartTransition& transition : chart.transitions) {
      const auto ends = EndsOf(outermost_, chart, place, transition);
      if (!ends) continue;
      const std::string arrow = Arrow(*ends, transition.when, transition.into);
      if (transition.target.empty()) {
        Line(place, arrow);
      } else {
        between_.push_back(arrow);  // a node in a line of a cluster would be drawn in it
      }
    }
  }

  void DrawState(const Chart::Node& node, std::size_t state, const Place& place) {
    const std::string id = place.IdOf(state);
    const bool present = present_.contains(place.PathOf(node));
    const std::string style = DotStyle(node, present);
    if (node.inside.empty()) {
      Line(place, id + " [label=" + DotQuoted(LabelOf(node, "\n")) + style + "]");
      return;
    }
    text_ += place.indent + "subgraph cluster_" + id + " {\n";
    Line(place.Inside(state, node, 0), "graph [label=" + DotQuoted(LabelOf(node, "\n")) +
                                           ", fontname=\"sans-serif\", style=\"rounded,filled\"" +
                                           (present ? "" : ", fillcolor=white") + style + "]");
    for (std::size_t i = 0; i < node.inside.size(); ++i) {
      Place inside = place.Inside(state, node, i);
      if (node.inside.size() == 1) {
        DrawInside(node.inside[i], inside);
        continue;
      }
      text_ += inside.indent + "subgraph cluster_" + id + "_region" + std::to_string(i) + " {\n";
      inside.indent += "  ";
      Line(inside, "graph [label=" + DotQuoted(node.inside[i].name) + ", style=\"dashed\"]");
      DrawInside(node.inside[i], inside);
      text_ += place.indent + "  }\n";
    }
    text_ += place.indent + "}\n";
  }

  // Graphviz draws arrows between nodes only. The arrows of a cluster begin and end at its start
  // state, and are cut at its border.
  std::string Arrow(const Ends& ends, const std::string& when, Into into) {
    std::string style;
    if (!when.empty()) style += ", label=" + DotQuoted(when);
    if (ends.from != ends.to) {
      if (ends.from_holds) style += ", ltail=cluster_" + ends.from;
      if (ends.to_holds && into == Into::kStart) style += ", lhead=cluster_" + ends.to;
    }
    std::string head = ends.to_holds ? ends.to + "_start" : ends.to;
    if (into != Into::kStart) {
      const bool deep = into == Into::kDeepHistory;
      head = ends.to + (deep ? "_deep" : "_history");
      between_.push_back("subgraph cluster_" + ends.to + " { " + head +
                         " [shape=circle, label=\"H" + (deep ? "*" : "") + "\"] }");
    }
    const std::string tail = ends.from_holds ? ends.from + "_start" : ends.from;
    return tail + " -> " + head + (style.empty() ? "" : " [" + style.substr(2) + "]");
  }

  void Line(const Place& place, const std::string& line) { text_ += place.indent + line + ";\n"; }

  const Chart& outermost_;
  std::set<std::string> present_;
  std::string text_;
  std::vector<std::string> between_;  // lines about states of two machines
};

class Mermaid {
 public:
  Mermaid(const Chart& outermost, std::string_view present) : outermost_(outermost) {
    AddPresent(present, "", present_);
  }

  std::string Draw() && {
    text_ = "stateDiagram-v2\n";
    DrawInside(outermost_, {"s", "  "});
    for (const std::string& line : between_) text_ += "  " + line + "\n";
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
      const auto ends = EndsOf(outermost_, chart, place, transition);
      if (!ends) continue;
      const std::string arrow = Arrow(*ends, transition.when, transition.into);
      if (transition.target.empty()) {
        Line(place, arrow);
      } else {
        between_.push_back(arrow);
      }
    }
    for (std::size_t i = 0; i < chart.states.size(); ++i) {
      if (chart.states[i].role == Role::kFinal) Line(place, place.IdOf(i) + " --> [*]");
    }
  }

  static std::string Arrow(const Ends& ends, const std::string& when, Into into) {
    std::string text = MermaidText(when);
    if (into != Into::kStart) {
      const std::string history = into == Into::kDeepHistory ? "(H*)" : "(H)";
      text += (text.empty() ? "" : " ") + history;
    }
    return ends.from + " --> " + ends.to + (text.empty() ? "" : " : " + text);
  }

  void DrawState(const Chart::Node& node, std::size_t state, const Place& place) {
    const std::string id = place.IdOf(state);
    const std::string line = "state \"" + MermaidText(LabelOf(node, ", ")) + "\" as " + id;
    if (node.role == Role::kSafe) classes_ += "  class " + id + " safe\n";
    if (present_.contains(place.PathOf(node))) classes_ += "  class " + id + " present\n";
    if (node.inside.empty()) return Line(place, line);
    Line(place, line + " {");
    for (std::size_t i = 0; i < node.inside.size(); ++i) {
      const Place inside = place.Inside(state, node, i);
      if (i > 0) Line(inside, "--");
      DrawInside(node.inside[i], inside);
    }
    Line(place, "}");
  }

  void Line(const Place& place, const std::string& line) { text_ += place.indent + line + "\n"; }

  const Chart& outermost_;
  std::set<std::string> present_;
  std::string text_;
  std::vector<std::string> between_;  // arrows between states of two machines
  std::string classes_;               // at the end, where Mermaid expects them
};

}  // namespace

std::string ToDot(const Chart& chart, std::string_view present) {
  return Dot(chart, present).Draw();
}

std::string ToMermaid(const Chart& chart, std::string_view present) {
  return Mermaid(chart, present).Draw();
}

}  // namespace musher::fsm
