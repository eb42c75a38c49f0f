#pragma once
// The page of CyberDog's interfaces (docs/cyberdog.md) held against the code.
//
// Names stand as `code` in the first column of its tables: under "## What is implemented" those
// that the code has as a string, under "## What is left out" those that it has not. Every message
// type of CyberDog's package `protocol`, and every topic and service of the manager, is on the
// page.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// What is wrong with `page`; `tree` is all files.
std::vector<std::string> WrongInterfaces(const SourceFile& page,
                                         const std::vector<SourceFile>& tree);

}  // namespace musher::house
