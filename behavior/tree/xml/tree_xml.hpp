#pragma once
// Reads the XML of BehaviorTree.CPP 4:
//
//   <root BTCPP_format="4" main_tree_to_execute="Main">
//     <include path="parts.xml"/>
//     <BehaviorTree ID="Main"> <Sequence> ... </Sequence> </BehaviorTree>
//     <TreeNodesModel> ... </TreeNodesModel>
//   </root>
//
// The path of an include is relative to the file that it stands in. Every file is read once. All
// errors are reported at once, as "file:line:column: error: …"; of a file that is no XML the first.
// A file has at most 4 MiB and elements in each other to a depth of 100, a limit of the parser;
// subtrees make deeper trees.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/result.hpp"
#include "musher/behavior/tree/document.hpp"

namespace musher::tree {

struct Reading {
  Document document;
  std::vector<Diagnostic> diagnostics;  // also warnings; with errors it must not be built

  bool ok() const { return !HasError(diagnostics); }
};

// The text of a file. The Error's message says why there is none.
using ReadText = std::function<Result<std::string>(const std::string& path)>;

Reading ReadTree(std::string_view text, const std::string& file, const ReadText& read = {});
Reading ReadTreeFile(const std::string& path);
// A file that may have models of nodes only.
Reading ReadModelsFile(const std::string& path);

}  // namespace musher::tree
