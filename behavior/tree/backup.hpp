#pragma once
// The values of a tree's blackboards, to go back to them: after a tree was tried, or in a tree that
// is built again.
//
//   const tree::Backup before(*tree);
//   ...
//   restored = before.Restore(*tree);
//
// It has the board of the main tree and those of the subtrees; what a board around the main tree
// has belongs to other trees, too.
//
// Threads: as the tree; a Backup has no part in it.

#include <map>
#include <string>
#include <vector>

#include "musher/behavior/tree/tree.hpp"

namespace musher::tree {

class Backup {
 public:
  explicit Backup(const Tree& tree);

  // Each value counts as set again; an entry without one is cleared. Fails, and changes nothing,
  // where the tree has another name, other subtrees, or an entry with a type that the value can not
  // have.
  Result<> Restore(Tree& tree) const;

 private:
  std::vector<std::string> paths_;  // by board
  std::vector<std::map<std::string, Value>> boards_;
};

}  // namespace musher::tree
