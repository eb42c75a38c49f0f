#pragma once
// The page of CyberDog's interfaces (docs/cyberdog.md) held against the code.
//
// Names stand as `code` in the first column of its tables. The code has the names under "## What is
// implemented" as strings, and has no string for a name under "## What is left out". Every message
// type of CyberDog's package `protocol`, and every topic and service of the manager, is on the
// page.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// What is wrong with `page`; `tree` is all files.
std::vector<std::string> WrongInterfaces(const SourceFile& page,
                                         const std::vector<SourceFile>& tree);

// Constants of the manager's interfaces (cyberdog/interfaces.hpp) that `list`, the permissions of
// all of them (interfaces.cpp), lacks: every actuator may use those.
std::vector<std::string> UnlistedInterfaces(const SourceFile& constants, const SourceFile& list);

// Modules of `constants` (cyberdog/codes/module_codes.hpp) that have no name in `names` (the .cpp
// beside it), or several, and names of no such module.
std::vector<std::string> WronglyNamedModules(const SourceFile& constants, const SourceFile& names);

}  // namespace musher::house
