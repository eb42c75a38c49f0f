#include "musher/behavior/tree/tree.hpp"

#include <algorithm>
#include <utility>

namespace musher::tree {

Tree::Tree(std::string name, std::size_t history) : name_(std::move(name)), trace_(history) {
  tick_.trace = &trace_;
}

Tree::~Tree() = default;

Result<Status> Tree::TickExactlyOnce(Time now) {
  tick_.now = std::max(tick_.now, now);
  tick_.woken = false;
  tick_.fault.clear();
  Node& root = *nodes_.front();
  const std::shared_ptr<Hooks> hooks = hooks_.lock();
  if (hooks != nullptr) hooks->BeginTick();
  tick_.hooks = hooks.get();
  try {
    const Status status = root.Execute(tick_);
    if (IsCompleted(status)) root.Reset(tick_);
    if (tick_.fault.empty()) return status;
    root.Reset(tick_);  // a node threw while it was halted
    return HaltFault();
  } catch (const NodeFault& fault) {
    const std::string what = Path(fault.node->id()) + ": " + fault.what;
    root.Reset(tick_);
    return Error{kCodeFailed, what};
  }
}

Result<Status> Tree::TickOnce(Time now) {
  Result<Status> result = TickExactlyOnce(now);
  for (int i = 1; i < kMostTicksAtOnce; ++i) {
    if (!tick_.woken || !result || result.value() != Status::kRunning) break;
    result = TickExactlyOnce(now);
  }
  return result;
}

void Tree::Attach(const std::shared_ptr<Hooks>& hooks) {
  hooks_ = hooks;
  hooks->ForEach([this](const Hook& hook) {
    if (hook.node < nodes_.size()) nodes_[hook.node]->special_ = true;
  });
}

Result<> Tree::Halt(Time now) {
  tick_.now = std::max(tick_.now, now);
  tick_.fault.clear();
  nodes_.front()->Reset(tick_);
  if (tick_.fault.empty()) return Ok();
  return HaltFault();
}

Error Tree::HaltFault() const {
  return {kCodeFailed, Path(tick_.faulty) + ": " + tick_.fault};
}

std::string Tree::Path(NodeId id) const {
  std::string path = infos_.at(id).name;
  for (NodeId at = infos_[id].parent; at != kNoNode; at = infos_[at].parent) {
    path = infos_[at].name + "/" + path;
  }
  return name_ + "/" + path;
}

std::optional<NodeId> Tree::Find(std::string_view path) const {
  for (NodeId id = 0; id < infos_.size(); ++id) {
    if (path.ends_with(infos_[id].name) && Path(id) == path) return id;
  }
  return std::nullopt;
}

std::vector<NodeId> Tree::Children(NodeId id) const {
  std::vector<NodeId> children;
  for (NodeId child = id + 1; child < infos_.size(); ++child) {
    if (infos_[child].parent == id) children.push_back(child);
  }
  return children;
}

Duration Tree::Spent(NodeId id, Time now) const {
  const NodeRuns& runs = trace_.node(id);
  return status(id) == Status::kRunning ? runs.spent + (now - runs.since) : runs.spent;
}

std::string Tree::HistoryText() const {
  std::string text;
  for (std::size_t i = 0; i < history().size(); ++i) {
    const Change& change = history()[i];
    const double at_s = ToSeconds(change.at.time_since_epoch());
    text += NumberText(at_s) + " s " + Path(change.node) + ": " + std::string(Name(change.from)) +
            " -> " + std::string(Name(change.to)) + "\n";
  }
  return text;
}

}  // namespace musher::tree
