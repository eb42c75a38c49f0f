#include "musher/application/tree_report.hpp"

#include <algorithm>

#include "musher/behavior/tree/write_tree.hpp"

namespace musher {
namespace {

std::uint8_t ToCode(tree::Status status) {
  switch (status) {
    case tree::Status::kIdle:
      return msg::TreeState::kIdle;
    case tree::Status::kRunning:
      return msg::TreeState::kRunning;
    case tree::Status::kSuccess:
      return msg::TreeState::kSuccess;
    case tree::Status::kFailure:
      return msg::TreeState::kFailure;
    case tree::Status::kSkipped:
      return msg::TreeState::kSkipped;
  }
  return msg::TreeState::kIdle;
}

// The lines of a text, found once for all nodes.
class Lines {
 public:
  explicit Lines(std::string_view text) {
    for (std::size_t at = 0; at < text.size(); ++at) {
      if (text[at] == '\n') ends_.push_back(at);
    }
  }
  std::uint32_t Of(std::size_t at) const {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(ends_, at) - ends_.begin()) + 1;
  }

 private:
  std::vector<std::size_t> ends_;
};

void AddNodes(const TreeView& view, std::vector<msg::TreeNode>& nodes) {
  const tree::Tree& tree = *view.tree;
  std::vector<Lines> lines;
  if (view.document != nullptr) {
    for (const auto& file : view.document->files) lines.emplace_back(file.text);
  }
  nodes.reserve(tree.size());
  for (tree::NodeId id = 0; id < tree.size(); ++id) {
    const tree::NodeInfo& info = tree.info(id);
    msg::TreeNode node;
    node.name = info.name;
    node.type = info.id;
    node.kind = tree::Name(info.kind);
    node.parent = info.parent == tree::kNoNode ? -1 : static_cast<std::int32_t>(info.parent);
    if (info.place.file < lines.size()) {
      node.file = view.document->files[info.place.file].path;
      node.line = lines[info.place.file].Of(info.place.at);
    }
    node.spent_s = ToSeconds(tree.Spent(id, view.time->last()));
    node.runs = tree.runs(id).starts;
    nodes.push_back(std::move(node));
  }
}

void AddEntries(tree::Tree& tree, std::vector<msg::TreeEntry>& entries) {
  std::vector<bool> done;
  for (tree::NodeId id = 0; id < tree.size(); ++id) {
    const tree::NodeInfo& info = tree.info(id);
    if (done.size() <= info.board) done.resize(info.board + 1);
    if (done[info.board]) continue;
    done[info.board] = true;
    const std::string path = info.parent == tree::kNoNode ? "" : tree.Path(info.parent);
    tree::Board& board = tree.board(id);
    for (const std::string& key : board.Keys()) {
      const tree::Entry* entry = board.Find(key);
      if (entry == nullptr) continue;
      const tree::Type* type = entry->value.empty() ? entry->type : entry->value.type();
      entries.push_back({path, key, type == nullptr ? "" : std::string(type->name),
                         entry->value.empty() ? "" : entry->value.Shown()});
    }
  }
}

void AddHistory(const TreeView& view, std::size_t most, std::vector<msg::TreeChange>& history) {
  const auto& changes = view.tree->history();
  const std::size_t count = std::min(changes.size(), most);
  history.reserve(count);
  for (std::size_t i = changes.size() - count; i < changes.size(); ++i) {
    const tree::Change& change = changes[i];
    history.push_back(
        {ToSeconds(view.time->At(change.at)), change.node, ToCode(change.from), ToCode(change.to)});
  }
}

}  // namespace

void TreeTime::Continue(Time now) {
  if (!counts_ || spans_.empty() || now < last_) {
    if (spans_.size() == kMostSpans) spans_.erase(spans_.begin());
    const Duration before = spans_.empty()
                                ? Duration{}
                                : spans_.back().before + (spans_.back().end - spans_.back().begin);
    spans_.push_back({now, now, before});
    counts_ = true;
  }
  spans_.back().end = now;
  last_ = now;
}

Duration TreeTime::At(Time when) const {
  if (spans_.empty()) return {};
  for (std::size_t i = spans_.size(); i-- > 0;) {
    const Span& span = spans_[i];
    if (when >= span.begin) return span.before + (std::min(when, span.end) - span.begin);
  }
  return spans_.front().before;
}

void ReportState(const TreeView& view, msg::TreeState& state) {
  state.tree = view.tree == nullptr ? "" : view.tree->name();
  state.revision = view.revision;
  state.ticking = view.ticking;
  state.ticks = view.ticks;
  state.time_s = ToSeconds(view.time->Now());
  state.last_fault = *view.last_fault;
  state.status.resize(view.tree == nullptr ? 0 : view.tree->size());
  for (tree::NodeId id = 0; id < state.status.size(); ++id) {
    state.status[id] = ToCode(view.tree->status(id));
  }
  if (!state.status.empty()) state.status[0] = ToCode(view.result);
}

msg::GetTree::Response ReportTree(const TreeView& view, const msg::GetTree::Request& request) {
  msg::GetTree::Response report;
  ReportState(view, report.state);
  if (!request.format.empty() && request.format != "dot" && request.format != "xml") {
    report.error = "unknown format '" + request.format + "'; expected dot or xml";
  }
  if (view.tree == nullptr) return report;
  AddNodes(view, report.nodes);
  if (request.entries) AddEntries(*view.tree, report.entries);
  AddHistory(view, request.history, report.history);
  if (request.format == "dot") report.graph = tree::ToDot(*view.tree);
  if (request.format == "xml" && view.document != nullptr) {
    report.graph = tree::WriteTree(*view.tree, *view.document);
  }
  return report;
}

}  // namespace musher
