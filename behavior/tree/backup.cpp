#include "musher/behavior/tree/backup.hpp"

#include <utility>

#include "musher/base/words.hpp"

namespace musher::tree {
namespace {

bool IsOuter(const std::string& key) {
  return key.starts_with('@');
}

// The path of the subtree of each board; for the main board the name of the tree.
std::vector<std::string> BoardPaths(const Tree& tree) {
  std::vector<std::string> paths(tree.boards().size());
  paths.front() = tree.name();
  for (NodeId id = 0; id < tree.size(); ++id) {
    const NodeInfo& info = tree.info(id);
    std::string& path = paths.at(info.board);
    if (path.empty()) path = tree.Path(info.parent);
  }
  return paths;
}

}  // namespace

Backup::Backup(const Tree& tree) : paths_(BoardPaths(tree)) {
  for (const auto& board : tree.boards()) {
    auto& values = boards_.emplace_back();
    for (const std::string& key : board->Keys()) {
      if (!IsOuter(key)) values[key] = board->Find(key)->value;
    }
  }
}

Result<> Backup::Restore(Tree& tree) const {
  if (boards_.size() != tree.boards().size()) {
    return Error{kCodeFailed, "the backup has " + Counted(boards_.size(), "blackboard") +
                                  ", tree " + tree.name() + " has " +
                                  std::to_string(tree.boards().size())};
  }
  const std::vector<std::string> paths = BoardPaths(tree);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i] == paths_[i]) continue;
    return Error{kCodeFailed, "the backup has a blackboard of " + paths_[i] + ", tree " +
                                  tree.name() + " has one of " + paths[i] + " in its place"};
  }
  std::map<Entry*, Value> values;  // also of what the backup does not have
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    Board& board = *tree.boards()[i];
    for (const std::string& key : board.Keys()) {
      if (!IsOuter(key)) values.try_emplace(board.Find(key));
    }
    for (const auto& [key, value] : boards_[i]) {
      const Entry* entry = board.Find(key);
      if (value.empty() || entry == nullptr || entry->type == nullptr) continue;
      Value fitting;
      if (const Result<> fits = fitting.SetAs(*entry->type, value); !fits) {
        return Error{kCodeFailed, "entry '" + key + "': " + fits.error().message};
      }
    }
  }
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    for (const auto& [key, value] : boards_[i]) values[&tree.boards()[i]->At(key)] = value;
  }
  for (auto& [entry, value] : values) {
    if (value.empty()) {
      entry->value.Clear();
    } else if (Result<> set = entry->Assign(value); !set) {
      return set;
    }
  }
  return Ok();
}

}  // namespace musher::tree
