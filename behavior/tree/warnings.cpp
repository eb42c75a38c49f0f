// What a tree may do that its author seldom wants. The rules are in docs/behavior-trees.md.

#include <algorithm>
#include <array>
#include <optional>

#include "musher/base/suggest.hpp"
#include "musher/behavior/tree/builder.hpp"
#include "musher/behavior/tree/conditions.hpp"

namespace musher::tree {
namespace {

using namespace std::string_view_literals;  // of these == looks at the sizes first

// The fixed number of an attribute. Nothing: it is missing or an entry.
std::optional<double> FixedNumber(const Element& element, std::string_view name) {
  const Attribute* attribute = element.Find(name);
  if (attribute == nullptr) return std::nullopt;
  const Result<double> number = Convert<double>::FromText(attribute->value);
  return number ? std::optional(number.value()) : std::nullopt;
}

}  // namespace

void Builder::Warn() {
  // A node takes time if it or one below may return RUNNING: children have higher ids.
  std::vector<NodeInfo>& infos = tree_->infos_;
  std::vector<std::vector<NodeId>> children(infos.size());
  std::vector<char> unsure(infos.size(), 0);
  std::vector<std::set<std::string>> uses(infos.size());  // parts of the robot
  for (NodeId id = static_cast<NodeId>(infos.size()); id-- > 0;) {
    const NodeId parent = infos[id].parent;
    const Factory::Registered* registered = registered_[id];
    if (registered != nullptr && registered->placeholder) unsure[id] = 1;
    const bool is_subtree = infos[id].kind == NodeKind::kSubtree;
    if (registered != nullptr && !is_subtree && !registered->uses.empty()) {
      uses[id].insert(registered->uses);
    }
    if (parent == kNoNode) continue;
    uses[parent].insert(uses[id].begin(), uses[id].end());
    if (unsure[id] != 0) unsure[parent] = 1;
    if (infos[id].takes_time) infos[parent].takes_time = true;
  }
  for (NodeId id = 0; id < infos.size(); ++id) {
    if (infos[id].parent != kNoNode) children[infos[id].parent].push_back(id);
  }
  for (NodeId id = 0; id < infos.size(); ++id) {
    WarnOfReactive(id, children[id]);
    WarnOfTime(id, children[id], unsure[id] != 0);
    WarnOfParallel(id, children[id].size());
    WarnOfShared(id, children[id], uses);
  }
  WarnOfUnset();
  WarnOfUnmade();
}

void Builder::WarnOfReactive(NodeId id, const std::vector<NodeId>& children) {
  const NodeInfo& info = tree_->infos_[id];
  if (info.id != "ReactiveSequence"sv && info.id != "ReactiveFallback"sv) return;
  for (const NodeId child : children) {
    const NodeInfo& other = tree_->infos_[child];
    if (child == children.back() || !other.takes_time) continue;
    Report(other.place, Severity::kWarning,
           "'" + other.name + "' may return RUNNING, and is not the last child of " + info.id +
               ": it is started again in each tick after it has completed, and each time it runs "
               "the children behind it are halted");
  }
}

void Builder::WarnOfTime(NodeId id, const std::vector<NodeId>& children, bool unsure) {
  const NodeInfo& info = tree_->infos_[id];
  const Element& element = *elements_[id];
  const bool at_once = children.size() == 1 && !tree_->infos_[children[0]].takes_time && !unsure;
  if (info.id == "Timeout"sv) {
    if (FixedNumber(element, "msec") == 0.0) {
      Report(info.place, Severity::kWarning, "msec=\"0\" is no limit");
    } else if (at_once) {
      Report(info.place, Severity::kWarning,
             "Timeout has no effect: nothing below it may return RUNNING");
    }
  }
  if (info.id != "Repeat"sv && info.id != "RetryUntilSuccessful"sv) return;
  const std::string limit = info.id == "Repeat"sv ? "num_cycles" : "num_attempts";
  const std::optional<double> times = FixedNumber(element, limit);
  if (times && *times < -1.0) {
    Report(element.Find(limit)->value_at, Severity::kWarning,
           limit + " below -1 counts as 0; -1 is without a limit");
  }
  if (times == -1.0 && at_once) {
    Report(info.place, Severity::kWarning,
           info.id + " has no limit and nothing below it may return RUNNING: TickOnce() ticks " +
               std::to_string(Tree::kMostTicksAtOnce) + " times");
  }
}

void Builder::WarnOfParallel(NodeId id, std::size_t children) {
  const NodeInfo& info = tree_->infos_[id];
  if (info.id != "Parallel"sv && info.id != "ParallelAll"sv) return;
  const Element& element = *elements_[id];
  for (const std::string_view port : {"success_count", "failure_count", "max_failures"}) {
    const auto count = FixedNumber(element, port);
    if (!count || *count <= static_cast<double>(children)) continue;
    Report(element.Find(port)->value_at, Severity::kError,
           std::string(port) + " is more than the number of its children, " +
               std::to_string(children));
  }
}

// Children that may run at the same time and use the same part of the robot. Conditions may keep
// those of a Parallel apart. PipelineSequence ticks those before the present one again; where they
// have ended by then, they do not wait.
void Builder::WarnOfShared(NodeId id, const std::vector<NodeId>& children,
                           const std::vector<std::set<std::string>>& uses) {
  const NodeInfo& info = tree_->infos_[id];
  if (info.kind != NodeKind::kControl) return;
  const bool parallel = info.id == "Parallel"sv || info.id == "ParallelAll"sv;
  if (!parallel && info.id != "PipelineSequence"sv && info.id != "NonblockingSequence"sv) return;
  std::map<std::string, NodeId> first;  // child that uses the part
  for (const NodeId child : children) {
    for (const std::string& part : uses[child]) {
      const auto [found, added] = first.emplace(part, child);
      if (added) continue;
      const NodeInfo& other = tree_->infos_[child];
      Report(other.place, Severity::kWarning,
             "'" + tree_->infos_[found->second].name + "' and '" + other.name + "' both use the " +
                 part + ", which only one of them can have at a time, and " + info.id +
                 " may run them together");
    }
  }
}

// An entry that is read and never set is often misspelt. A script that reads one ends the tick.
void Builder::WarnOfUnset() {
  std::vector<std::string> written;
  for (const auto& [entry, key] : writes_) written.push_back(entry->key);
  std::ranges::sort(written);
  written.erase(std::unique(written.begin(), written.end()), written.end());
  constexpr std::size_t kShortest = 4;  // shorter ones are near to too many
  std::set<const Entry*> reported;
  for (const auto& [entry, place] : reads_) {
    if (entry->key.size() < kShortest) continue;
    if (writes_.contains(entry) || !entry->value.empty()) continue;
    const std::string hint = DidYouMean(entry->key, written);
    if (hint.empty()) continue;
    reported.insert(entry);
    Report(place, Severity::kWarning, "nothing in the tree sets '" + entry->key + "'" + hint);
  }
  if (!unknown_.empty()) return;  // what is missing may set it
  for (const auto& [entry, place] : script_reads_) {
    if (writes_.contains(entry) || !entry->value.empty()) continue;
    if (!reported.insert(entry).second) continue;
    Report(place, Severity::kWarning,
           "nothing in the tree sets '" + entry->key +
               "', and without a value this script ends the mission, unless the program sets it");
  }
}

// The test would run the robot's own node. A pattern may be for another tree.
void Builder::CheckSubstitutions() {
  if (!unknown_.empty()) return;  // leaves are missing
  std::vector<std::string> names;
  for (const LeafNames& leaf : leaves_) {
    names.insert(names.end(), {leaf.name, leaf.id, leaf.path, leaf.tree_path});
  }
  for (const Substitution& each : factory_.substitutions()) {
    if (std::ranges::any_of(leaves_, [&](const auto& leaf) { return each.Matches(leaf); }))
      continue;
    if (each.has_wildcard()) {
      Report({}, Severity::kWarning,
             "no leaf has a name or path like '" + each.pattern + "', which has a substitution");
    } else {
      Report({}, Severity::kError,
             "no leaf has the name, class or path '" + each.pattern +
                 "', which has a substitution" + DidYouMean(each.pattern, names));
    }
  }
}

// An assignment with '=' ends the tick where the entry does not exist.
void Builder::WarnOfUnmade() {
  for (const Need& need : needed_) {
    const Entry& entry = *need.entry;
    if (entry.declared || !entry.value.empty()) continue;
    const auto makers = made_.find(&entry);
    const bool too_late =
        makers != made_.end() && need.always && std::ranges::all_of(makers->second, [&](NodeId id) {
          return id > need.node && StartsBefore(need.node, id);
        });
    if (makers != made_.end() && !too_late) continue;
    Report(need.place, Severity::kWarning,
           (too_late ? "only what runs later makes '" : "nothing in the tree makes '") + entry.key +
               "', which '=' needs: use ':=', unless the program sets it");
  }
}

// Whether `node` has its first tick before `later`, which stands behind it in the file or below it,
// whatever nodes return.
bool Builder::StartsBefore(NodeId node, NodeId later) const {
  static constexpr std::array kTickInOrder = {
      "Sequence"sv,         "AsyncSequence"sv, "SequenceWithMemory"sv,
      "ReactiveSequence"sv, "Fallback"sv,      "AsyncFallback"sv,
      "ReactiveFallback"sv, "Parallel"sv,      "ParallelAll"sv};
  static constexpr std::array kBeginWithTheFirst = {
      "IfThenElse"sv,   "WhileDoElse"sv, "TryCatch"sv,
      "Finally"sv,      "Inverter"sv,    "ForceSuccess"sv,
      "ForceFailure"sv, "Timeout"sv,     "KeepRunningUntilFailure"sv,
      "RunOnce"sv};
  const std::vector<NodeInfo>& infos = tree_->infos_;
  const auto is_among = [](const auto& names, const NodeInfo& info) {
    return info.kind != NodeKind::kSubtree && std::ranges::find(names, info.id) != names.end();
  };
  std::set<NodeId> around_later;
  for (NodeId id = later; id != kNoNode; id = infos[id].parent) around_later.insert(id);
  for (NodeId at = node; !around_later.contains(at); at = infos[at].parent) {
    if (tree_->nodes_[at]->conditions_ != nullptr) return false;  // it may be skipped
    const NodeInfo& parent = infos[infos[at].parent];
    const bool in_order = is_among(kTickInOrder, parent);
    const bool is_first = at == infos[at].parent + 1;
    const bool begins_with_it =
        in_order || parent.kind == NodeKind::kSubtree || is_among(kBeginWithTheFirst, parent);
    if (is_first ? begins_with_it : in_order && around_later.contains(infos[at].parent)) continue;
    return false;
  }
  return true;
}

}  // namespace musher::tree
