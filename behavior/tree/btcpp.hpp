#pragma once
// What BehaviorTree.CPP 4.10 does differently with a file, for a tree that runs in both.

#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/tree/document.hpp"
#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {

// A warning at each place of the trees that behaves differently there, by place. Each says what
// BehaviorTree.CPP does and what this engine does. The factory has the nodes, or placeholders. What
// only a running program shows is not found: docs/behavior-trees.md has all differences.
std::vector<Diagnostic> DifferencesToBtcpp(const Document& document, const Factory& factory);

}  // namespace musher::tree
