#pragma once
// A tree as XML again, of the nodes that were built: without includes, and without trees that it
// does not use.

#include <map>
#include <string>

#include "musher/behavior/tree/document.hpp"
#include "musher/behavior/tree/tree.hpp"

namespace musher::tree {

struct WriteOptions {
  // With the attribute `_uid` of each node, its id + 1, and `_fullpath` of each subtree, which is
  // then written once for each place where it is used: what BehaviorTree.CPP writes for monitors.
  bool with_ids = false;
  // With the nodes' ports as <TreeNodesModel>; null: without.
  const Factory* models = nullptr;
};

// The `_fullpath` of each subtree, which BehaviorTree.CPP also calls its blackboard by: "rest",
// "rest/inner"; "Rest::3", with the uid, where it has no name of its own. Each is there once.
std::map<NodeId, std::string> SubtreePaths(const Tree& tree);

// `document`: the one that the tree was built from.
std::string WriteTree(const Tree& tree, const Document& document, const WriteOptions& options = {});

}  // namespace musher::tree
