#include "musher/behavior/tree/tree.hpp"

#include <algorithm>
#include <utility>

namespace musher::tree {

Tree::Tree(std::string name, std::size_t history) : name_(std::move(name)), trace_(history) {
  tick_.trace = &trace_;
}

Tree::~Tree() {
  OnWakeUp(nullptr);
}

namespace {

// Marks the tree as busy within a tick or a halt.
class Busy {
 public:
  explicit Busy(bool& busy) : busy_(busy) { busy_ = true; }
  ~Busy() { busy_ = false; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  bool& busy_;
};

Error OfOwnTree(const std::string& tree, const std::string& does) {
  return {kCodeFailed,
          "a node of tree " + tree + " " + does + " its own tree: do that after the tick"};
}

}  // namespace

Result<Status> Tree::TickExactlyOnce(Time now) {
  if (busy_) return OfOwnTree(name_, "ticks");
  const Busy busy(busy_);
  BeginAt(now);
  tick_.woken = false;
  tick_.fault.clear();
  if (wake_up_ == nullptr) return TickNodes();
  wake_up_->requested = false;
  wake_up_->again = false;
  wake_up_->ticks = true;
  Result<Status> result = TickNodes();
  wake_up_->ticks = false;
  tick_.woken |= wake_up_->again;
  return result;
}

Result<Status> Tree::TickNodes() {
  Node& root = *nodes_.front();
  const std::shared_ptr<Hooks> hooks = hooks_.lock();
  if (hooks != nullptr) hooks->BeginTick();
  tick_.hooks = hooks.get();
  try {
    if (begins_) BeginRun();
    const Status status = root.Execute(tick_);
    if (IsCompleted(status)) root.Reset(tick_);
    if (status != Status::kRunning) EndRun();
    if (tick_.fault.empty()) return status;
    HaltNodes();  // a node threw while it was halted
    EndRun();
    return Fault(tick_.faulty, tick_.fault);
  } catch (const NodeFault& fault) {
    HaltNodes();
    EndRun();
    return Fault(fault.node->id(), fault.what);
  }
}

// From the root, and then what still runs below a node that threw before it halted its children.
void Tree::HaltNodes() {
  nodes_.front()->Reset(tick_);
  for (const auto& node : nodes_) {
    if (node->running()) node->Reset(tick_);
  }
}

void Tree::BeginAt(Time now) {
  tick_.now = std::max(tick_.now, now);
  ++tick_.number;
  boards_.front()->SetTime(tick_.now);
}

void Tree::BeginRun() {
  begins_ = false;
  for (const auto& [node, observer] : run_observers_) {
    try {
      observer->OnNewRun(tick_);
    } catch (const std::exception& error) {
      throw NodeFault{node, error.what()};
    }
  }
}

void Tree::EndRun() {
  if (begins_) return;
  begins_ = true;
  ++tick_.number;
  ++tick_.run;
  if (const auto hooks = hooks_.lock()) hooks->EndHolds();
}

Result<Status> Tree::TickOnce(Time now) {
  Result<Status> result = TickExactlyOnce(now);
  for (int i = 1; i < kMostTicksAtOnce; ++i) {
    if (!tick_.woken || !result || result.value() != Status::kRunning) break;
    result = TickExactlyOnce(now);
  }
  return result;
}

void Tree::OnWakeUp(std::function<void()> notify) {
  if (wake_up_ != nullptr) wake_up_->notify = std::move(notify);
}

void Tree::Attach(const std::shared_ptr<Hooks>& hooks) {
  hooks_ = hooks;
  hooks->ForEach([this](const Hook& hook) {
    if (hook.node < nodes_.size()) nodes_[hook.node]->special_ = true;
  });
}

Result<> Tree::Halt(Time now) {
  if (busy_) return OfOwnTree(name_, "halts");
  const Busy busy(busy_);
  BeginAt(now);
  tick_.fault.clear();
  HaltNodes();
  EndRun();
  if (tick_.fault.empty()) return Ok();
  return Fault(tick_.faulty, tick_.fault);
}

Error Tree::Fault(NodeId id, const std::string& what) const {
  return {kCodeFailed, PlaceOf(id) + ": " + Path(id) + ": " + what};
}

std::string Tree::Path(NodeId id) const {
  std::string path = NameAmongSiblings(id);
  for (NodeId at = infos_[id].parent; at != kNoNode; at = infos_[at].parent) {
    path = NameAmongSiblings(at) + "/" + path;
  }
  return name_ + "/" + path;
}

std::string Tree::NameAmongSiblings(NodeId id) const {
  const NodeInfo& info = infos_.at(id);
  if (info.parent == kNoNode) return info.name;
  std::size_t number = 1;
  for (NodeId other = info.parent + 1; other < id; ++other) {
    if (infos_[other].parent == info.parent && infos_[other].name == info.name) ++number;
  }
  return number == 1 ? info.name : info.name + "#" + std::to_string(number);
}

std::string Tree::PlaceOf(NodeId id) const {
  const NodeInfo& info = infos_.at(id);
  return files_.at(info.place.file) + ":" + std::to_string(info.line) + ":" +
         std::to_string(info.column);
}

std::optional<NodeId> Tree::Find(std::string_view path) const {
  for (NodeId id = 0; id < infos_.size(); ++id) {
    if (path.find(infos_[id].name) != std::string_view::npos && Path(id) == path) return id;
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
