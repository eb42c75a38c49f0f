#pragma once
// Builds the tree of an actuator. Plain functions.

#include <functional>
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

// Sets entries of the blackboard from texts. An Error names each key that no node has, and each
// value that is not of the entry's type.
Result<> SetEntries(tree::Board& board,
                    const std::vector<std::pair<std::string, std::string>>& entries);

}  // namespace musher
