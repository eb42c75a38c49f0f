#pragma once
// Files that no target builds are dead code; a test that no target builds never runs.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// The .cpp files of `tree` that no CMakeLists.txt names. A CMakeLists.txt names files relative to
// its own folder.
std::vector<std::string> DeadFiles(const std::vector<SourceFile>& tree);

}  // namespace musher::house
