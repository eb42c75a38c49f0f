#pragma once
// Builds the tree of an actuator.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/result.hpp"
#include "musher/behavior/tree/build.hpp"

namespace musher {

// The errors of `diagnostics`, a line each.
std::string ErrorLines(const std::vector<Diagnostic>& diagnostics);

using Warn = std::function<void(const std::string& line)>;

// The document of a file; an Error has all of its errors.
Result<tree::Document> ReadTreeDocument(const std::string& file, const Warn& warn);
// The tree of a document.
Result<std::unique_ptr<tree::Tree>> BuildTree(const tree::Document& document,
                                              const tree::Factory& factory,
                                              const tree::BuildOptions& options, const Warn& warn);

// What is set on a board around a tree while that tree is built and filled goes back where it was,
// unless Keep() is called: running trees use that board. A key that is new stays, without a value.
class OuterBoardGuard {
 public:
  explicit OuterBoardGuard(tree::Board* board);  // null: there is none
  ~OuterBoardGuard();
  OuterBoardGuard(const OuterBoardGuard&) = delete;
  OuterBoardGuard& operator=(const OuterBoardGuard&) = delete;
  void Keep() { board_ = nullptr; }

 private:
  tree::Board* board_;
  std::map<tree::Entry*, tree::Entry> before_;
};

// Sets entries of the blackboard from texts. An Error names each key that no node has, and each
// value that is not of the entry's type.
Result<> SetEntries(tree::Board& board,
                    const std::vector<std::pair<std::string, std::string>>& entries);

}  // namespace musher
