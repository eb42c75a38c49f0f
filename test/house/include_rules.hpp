#pragma once
// Which folder may include which, and where third-party headers may appear: the table of the house
// (docs/architecture.md) as code.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// What `file` includes and may not.
std::vector<std::string> ForbiddenIncludes(const SourceFile& file);

// Folders and subfolders whose files include each other in a circle. A module is one folder here.
std::vector<std::string> IncludeCycles(const std::vector<SourceFile>& tree);

}  // namespace musher::house
