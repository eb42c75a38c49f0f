#include <fmt/format.h>

#include <array>

#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/tree.hpp"
#include "musher/cli/render/tree_nodes.hpp"

namespace musher::cli {
namespace {

constexpr std::size_t kDeepestIndent = 60;  // deeper nodes stand below each other

struct StatusLook {
  std::string_view name;
  std::string_view glyph;
  Style style;
};

constexpr std::array<StatusLook, 5> kLooks = {{{"IDLE", "·", Style::kDim},
                                               {"RUNNING", "▶", Style::kBusy},
                                               {"SUCCESS", "✓", Style::kGood},
                                               {"FAILURE", "✗", Style::kBad},
                                               {"SKIPPED", "–", Style::kDim}}};

StatusLook LookOf(std::uint8_t status) {
  return status < kLooks.size() ? kLooks[status] : StatusLook{"?", "?", Style::kBad};
}

std::string Indent(std::size_t depth) {
  return std::string(2 * std::min(depth, kDeepestIndent), ' ');
}

std::string Head(const std::string& name, const msg::TreeState& state, bool colour) {
  std::string text = Paint(name, Style::kBold, colour) + "  ";
  if (state.tree.empty()) return text + Paint("no tree is loaded", Style::kBad, colour) + '\n';
  const StatusLook look = LookOf(StatusOf(state, 0));
  text += "tree " + state.tree + "  " + Paint(look.name, look.style, colour);
  if (!state.ticking) text += "  " + Paint("paused", Style::kBusy, colour);
  text += fmt::format("\n{} tick{} in {:.3f} s of its time\n", state.ticks,
                      state.ticks == 1 ? "" : "s", state.time_s);
  return text;
}

std::string Nodes(const msg::GetTree::Response& report, bool colour) {
  Table table({"NODE", "TYPE", "STATUS", "RUNNING", "RUNS"});
  const std::vector<std::size_t> depths = DepthsOf(report.nodes);
  for (std::size_t id = 0; id < report.nodes.size(); ++id) {
    const msg::TreeNode& node = report.nodes[id];
    const StatusLook look = LookOf(StatusOf(report.state, id));
    const bool has_run = node.runs > 0;
    table.Add({{Indent(depths[id]) + std::string(look.glyph) + " " + node.name, look.style},
               {TypeText(node), Style::kDim},
               {std::string(look.name), look.style},
               {has_run ? fmt::format("{:.3f} s", node.spent_s) : ""},
               {has_run ? std::to_string(node.runs) : ""}});
  }
  return table.Text(colour);
}

std::string Changes(const msg::GetTree::Response& report, bool colour) {
  Table table({"AT", "NODE", "FROM", "TO"});
  for (const msg::TreeChange& change : report.history) {
    table.Add({{fmt::format("{:.3f} s", change.time_s), Style::kDim},
               {PathOf(report.nodes, change.node)},
               {std::string(LookOf(change.from).name)},
               {std::string(LookOf(change.to).name), LookOf(change.to).style}});
  }
  return table.Text(colour);
}

std::string Entries(const msg::GetTree::Response& report, bool colour) {
  Table table({"BOARD", "KEY", "TYPE", "VALUE"});
  for (const msg::TreeEntry& entry : report.entries) {
    table.Add({{entry.board.empty() ? "-" : entry.board, Style::kDim},
               {entry.key},
               {entry.type, Style::kDim},
               {entry.value}});
  }
  return table.Text(colour);
}

// What follows the head.
std::string Body(const msg::GetTree::Response& shown, bool colour) {
  std::string text;
  if (!shown.state.last_fault.empty()) {
    text += Paint("last fault: " + shown.state.last_fault, Style::kBad, colour) + '\n';
  }
  if (!shown.nodes.empty()) text += Nodes(shown, colour);
  if (!shown.history.empty()) text += '\n' + Changes(shown, colour);
  if (!shown.entries.empty()) text += '\n' + Entries(shown, colour);
  return text;
}

// "12.500 s  Patrol/there  RUNNING -> SUCCESS"
std::string ChangeLine(const msg::GetTree::Response& shown, const msg::TreeChange& change,
                       bool colour) {
  const StatusLook look = LookOf(change.to);
  return fmt::format("{:>10.3f} s  {}  {} -> ", change.time_s, PathOf(shown.nodes, change.node),
                     LookOf(change.from).name) +
         Paint(look.name, look.style, colour) + '\n';
}

}  // namespace

std::string_view TreeStatusName(std::uint8_t status) {
  return LookOf(status).name;
}

std::string TreeText(const std::string& name, const msg::GetTree::Response& report, bool colour) {
  const msg::GetTree::Response shown = Printable(report);
  return Head(name, shown.state, colour) + Body(shown, colour);
}

std::string TreeLines(const msg::GetTree::Response& report, std::int64_t wall_ns, bool colour) {
  const msg::GetTree::Response shown = Printable(report);
  const std::string begin = Paint(LocalTime(wall_ns), Style::kDim, colour) + "  ";
  std::string text;
  for (const msg::TreeChange& change : shown.history) {
    text += begin + ChangeLine(shown, change, colour);
  }
  if (shown.history.empty()) {
    text += begin + fmt::format("{:>10.3f} s  {}\n", shown.state.time_s,
                                shown.state.ticking ? "ticking" : "paused");
  }
  return text;
}

std::string RecordedTreeText(const std::string& name, const RecordedMoment& moment, bool colour) {
  const msg::GetTree::Response shown = Printable(moment.report);
  const StatusLook look = LookOf(StatusOf(shown.state, 0));
  std::string text = Paint(Printable(name), Style::kBold, colour) + "  tree " + shown.state.tree +
                     "  " + Paint(look.name, look.style, colour);
  if (!shown.state.ticking) text += "  " + Paint("paused", Style::kBusy, colour);
  text += fmt::format("\nrecorded, {:.3f} of {:.3f} s", shown.state.time_s, moment.end_s);
  if (moment.trees > 1) text += fmt::format(", tree {} of {}", moment.number, moment.trees);
  if (moment.wall_us > 0) {
    text += ", " + LocalText(static_cast<std::int64_t>(moment.wall_us) * 1000);
  }
  return text + '\n' + Body(shown, colour);
}

std::string RecordedChangeLine(const msg::GetTree::Response& report, const msg::TreeChange& change,
                               bool colour) {
  return ChangeLine(Printable(report), change, colour);
}

std::string FileTreeText(const std::vector<FileNode>& all, bool colour) {
  std::vector<msg::TreeNode> nodes;
  nodes.reserve(all.size());
  for (const FileNode& one : all) nodes.push_back(one.node);
  const std::vector<std::size_t> depths = DepthsOf(nodes);
  std::string text;
  for (std::size_t id = 0; id < all.size(); ++id) {
    const std::string type = TypeText(nodes[id]);
    text += Indent(depths[id]) + Paint(Printable(nodes[id].name), Style::kBold, colour);
    if (!type.empty()) text += "  " + Printable(type);
    std::string attributes;
    for (const auto& [name, value] : all[id].attributes) {
      attributes += (attributes.empty() ? "  " : " ") + name + "=\"" + value + "\"";
    }
    text += Paint(Printable(attributes), Style::kDim, colour);
    text += '\n';
  }
  return text;
}

}  // namespace musher::cli
