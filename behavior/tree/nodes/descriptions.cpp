// What the nodes that Musher has do, for editors and docs/tree-nodes.md.

#include <algorithm>
#include <array>
#include <utility>

#include "musher/behavior/tree/models.hpp"

namespace musher::tree {
namespace {

using Description = std::pair<std::string_view, std::string_view>;

constexpr std::array kDescriptions = {
    // Controls.
    Description{"Sequence",
                "Ticks its children in order and goes on with the one that runs. Fails with the "
                "first that fails."},
    Description{"AsyncSequence", "A Sequence that returns RUNNING between two children."},
    Description{"SequenceWithMemory",
                "A Sequence that returns RUNNING between two children, and goes on with the same "
                "child after a failure or a halt."},
    Description{"ReactiveSequence",
                "A Sequence that begins with its first child in each tick, and halts the others "
                "when one runs."},
    Description{"Fallback",
                "Ticks its children in order and goes on with the one that runs. Succeeds with "
                "the first that succeeds."},
    Description{"AsyncFallback", "A Fallback that returns RUNNING between two children."},
    Description{"ReactiveFallback",
                "A Fallback that begins with its first child in each tick, and halts the others "
                "when one runs."},
    Description{"Parallel",
                "Ticks all children that have not ended, until enough have succeeded or failed. "
                "Halts the rest."},
    Description{"ParallelAll",
                "Ticks all children until each has ended. Fails where too many have failed."},
    Description{"IfThenElse",
                "Ticks the first child, then the second where it succeeds, else the third."},
    Description{"WhileDoElse",
                "Ticks the first child in each tick, then the second where it succeeds, else the "
                "third. Halts the other one, and both while the first is RUNNING."},
    Description{"TryCatch",
                "Ticks its children but the last in order. Where one fails, it ticks the last, and "
                "fails."},
    Description{"Finally",
                "Ticks the first child, then the second, also where the first fails or is halted; "
                "the first one's result."},
    Description{"ManualSelector",
                "Waits until a person selects one of its children by name, and ticks that one."},
    // Decorators.
    Description{"Inverter", "Exchanges SUCCESS and FAILURE."},
    Description{"ForceSuccess", "SUCCESS when its child has ended."},
    Description{"ForceFailure", "FAILURE when its child has ended."},
    Description{"Repeat", "Ticks its child again after each success, so many times."},
    Description{"RetryUntilSuccessful", "Ticks its child again after each failure, so many times."},
    Description{"KeepRunningUntilFailure",
                "Ticks its child again and again; RUNNING until it fails."},
    Description{"Delay", "RUNNING until the time is over, then ticks its child."},
    Description{"Timeout", "Halts its child and fails when the time is over."},
    Description{"RunOnce", "Ticks its child until it has ended once; is skipped from then on."},
    Description{"Precondition",
                "Ticks its child if the script holds when it starts; else has the other result."},
    Description{"LoopInt", "Ticks its child for each whole number of a queue."},
    Description{"LoopBool", "Ticks its child for each truth value of a queue."},
    Description{"LoopDouble", "Ticks its child for each number of a queue."},
    Description{"LoopString", "Ticks its child for each text of a queue."},
    Description{"SkipUnlessUpdated",
                "Ticks its child when the entry was set since the last time, else is skipped."},
    Description{
        "WaitValueUpdate",
        "Ticks its child when the entry was set since the last time, else returns RUNNING."},
    // Leaves.
    Description{"AlwaysSuccess", "SUCCESS."},
    Description{"AlwaysFailure", "FAILURE."},
    Description{"Script", "Runs a script; SUCCESS."},
    Description{"ScriptCondition", "SUCCESS where the script is true, else FAILURE."},
    Description{"SetBlackboard", "Sets an entry to a text, or to the value of another entry."},
    Description{"UnsetBlackboard", "Clears an entry."},
    Description{"Sleep", "RUNNING until the time is over, then SUCCESS."},
    Description{"WasEntryUpdated",
                "SUCCESS where the entry was set since the last tick of this node, else FAILURE."},
    Description{"EntryUpdated", "The same as WasEntryUpdated."},
};

}  // namespace

std::string_view DescriptionOf(std::string_view node) {
  if (node.starts_with("Switch") && node.size() == 7) {
    return "Ticks the child of the case that equals the variable, else the last one. Halts the "
           "other one.";
  }
  const auto* found =
      std::ranges::find_if(kDescriptions, [node](const auto& each) { return each.first == node; });
  return found == kDescriptions.end() ? "" : found->second;
}

}  // namespace musher::tree
