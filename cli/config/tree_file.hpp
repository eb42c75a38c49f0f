#pragma once
// A file with behaviour trees, without the program that runs it: the nodes that only the program
// has come from <TreeNodesModel> of the file, or of files of models.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/messages/musher_msgs/tree.hpp"

namespace musher::cli {

struct TreeFile {
  tree::Document document;
  std::vector<Diagnostic> diagnostics;
  std::unique_ptr<tree::Tree> tree;       // null: there are errors
  std::vector<std::string> placeholders;  // nodes of models that its trees use
  bool has_unknown = false;               // a node that neither Musher nor a model has
};

struct TreeFileOptions {
  std::vector<std::string> models{};  // files
  bool nav2 = false;                  // with the nodes of nav2
  std::string as{};                   // "btcpp-4.10": also what that does differently
  // Empty: the main tree, or else the first that no other one uses; the others are checked, too.
  std::string tree{};
};

TreeFile ReadTreeWithModels(const std::string& file, const TreeFileOptions& options);

// A node of a file, as a row of a table.
struct FileNode {
  msg::TreeNode node;
  std::vector<std::pair<std::string, std::string>> attributes;  // `msec`, `5`
};

// The nodes of a tree with those of its subtrees, or of each tree one after the other where none
// is the main one. An error: there is no tree `name`, or the subtrees are recursive or too large.
Result<std::vector<FileNode>> NodesOf(const tree::Document& document, const std::string& name);

}  // namespace musher::cli
