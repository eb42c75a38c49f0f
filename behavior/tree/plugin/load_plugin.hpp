#pragma once
// Loads nodes from a shared library, whose source has MUSHER_TREE_PLUGIN (plugin.hpp).
//
//   loaded = tree::LoadPlugin(factory, "/opt/arm/lib/libarm_nodes.so");
//
// The library stays loaded until the process ends. It runs as part of the program: load none that
// others can write. A program that is linked with static libraries of Musher has to export its
// symbols (in CMake ENABLE_EXPORTS).
//
// Threads: as the factory.

#include <string>

#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {

// With an error the factory stays as it is: there is no such file, it is no plugin, it was built by
// another compiler or with another version of Musher, it lacks a symbol, or a name is taken.
Result<> LoadPlugin(Factory& factory, const std::string& path);

}  // namespace musher::tree
