#pragma once
// Builds a tree from a document: makes each node by the factory, connects ports and scripts with
// entries of blackboards, and checks everything that is known before the first tick. All errors are
// reported at once, with their places in the files.
//
// Errors: an unknown node, a wrong number of children, a port that the node does not have, a
// required one that is missing, a text that is not of the port's type, an entry that ports use with
// different types, a script that is wrong, a missing or recursive subtree, a value of a given board
// that is not of the type of its ports. A board is as it was before where the build fails.
// Warnings: see docs/behavior-trees.md, "Warnings".

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/tree/document.hpp"
#include "musher/behavior/tree/factory.hpp"
#include "musher/behavior/tree/tree.hpp"

namespace musher::tree {

struct BuildOptions {
  std::string tree{};              // empty: main_tree_to_execute, or the only tree of the document
  std::size_t history = 256;       // changes that are kept
  bool any_root = false;           // where none is named, the first tree that no other one uses
  std::shared_ptr<Board> board{};  // of the main tree; null: a new one
};

struct Built {
  std::unique_ptr<Tree> tree;  // null where there are errors
  std::vector<Diagnostic> diagnostics;
};

// A tree has at most so many nodes, with those of its subtrees.
inline constexpr std::size_t kMostNodes = 100'000;
// Nodes in each other; each needs some stack in a tick.
inline constexpr int kDeepestTree = 1000;

Built Build(const Document& document, const Factory& factory, const BuildOptions& options = {});

}  // namespace musher::tree
