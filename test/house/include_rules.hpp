#pragma once
// Which folder may include which, and where third-party headers may appear: the table of the house
// (docs/architecture.md) as code.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// What `file` includes and may not.
std::vector<std::string> ForbiddenIncludes(const SourceFile& file);

}  // namespace musher::house
