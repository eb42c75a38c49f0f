#pragma once
// A shared library with nodes, which a program loads by its path (load_plugin.hpp). Its one source
// that registers them has
//
//   MUSHER_TREE_PLUGIN(factory) {
//     return factory.Add<Grip>("Grip");
//   }
//
// and is linked into a MODULE library. Where Musher's libraries are static ones, the library is not
// linked with them: it gets everything from the program.
//
// Threads: as the factory.

#include <array>
#include <cstddef>

#include "musher/behavior/tree/factory.hpp"

// What both have to have in common, beside the headers: the compiler with its standard library.
#define MUSHER_TREE_PLUGIN_BUILD "musher tree plugin 2, compiler " __VERSION__

// NOLINTBEGIN(bugprone-macro-parentheses): the argument is the name of a parameter.
// The body of a function that adds nodes to `factory`, and returns a Result<>.
#define MUSHER_TREE_PLUGIN(factory)                                                              \
  static musher::Result<> MusherAddNodes(musher::tree::Factory& factory);                        \
  extern "C" __attribute__((visibility("default"), used))                                        \
  const musher::tree::Plugin musher_tree_plugin = {MUSHER_TREE_PLUGIN_BUILD,                     \
                                                   musher::tree::TypeOf<double>(),               \
                                                   musher::tree::kPluginSizes, &MusherAddNodes}; \
  static musher::Result<> MusherAddNodes([[maybe_unused]] musher::tree::Factory& factory)
// NOLINTEND(bugprone-macro-parentheses)

namespace musher::tree {

// Another version of Musher mostly has other ones.
using PluginSizes = std::array<std::size_t, 6>;
inline constexpr PluginSizes kPluginSizes = {sizeof(Node),    sizeof(Entry),
                                             sizeof(Type),    sizeof(Setup),
                                             sizeof(Factory), sizeof(Factory::Registered)};

// The symbol `musher_tree_plugin` of the library.
struct Plugin {
  const char* build;  // stays first in every version
  const Type* number;
  PluginSizes sizes;
  Result<> (*add)(Factory& factory);
};

}  // namespace musher::tree
