#include "musher/behavior/tree/plugin/load_plugin.hpp"

#include <dlfcn.h>

#include <exception>
#include <string_view>
#include <utility>

#include "musher/behavior/tree/plugin/plugin.hpp"

namespace musher::tree {
namespace {

// The reason of the last failure.
std::string Reason() {
  const char* reason = dlerror();
  return reason == nullptr ? "unknown" : reason;
}

}  // namespace

Result<> LoadPlugin(Factory& factory, const std::string& path) {
  const auto fail = [&path](const std::string& what) {
    return Error{kCodeFailed, "plugin " + path + ": " + what};
  };
  // A name without '/' would be searched for in the folders of the system.
  const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) return fail(Reason());
  const auto* plugin = static_cast<const Plugin*>(dlsym(library, "musher_tree_plugin"));
  if (plugin == nullptr) {
    return fail("it has no nodes for Musher: none of its sources has MUSHER_TREE_PLUGIN");
  }
  if (std::string_view(plugin->build) != MUSHER_TREE_PLUGIN_BUILD) {
    return fail("it is '" + std::string(plugin->build) + "', the program needs '" +
                MUSHER_TREE_PLUGIN_BUILD +
                "': build it again with the program's compiler and version of Musher");
  }
  if (plugin->sizes != kPluginSizes) {
    return fail(
        "it was built with another version of Musher, or other options of the compiler: build it "
        "again");
  }
  if (plugin->number != TypeOf<double>()) {
    return fail(
        "it does not share the types of ports with the program, which has to export its "
        "symbols (in CMake: ENABLE_EXPORTS)");
  }
  Factory with_plugin = factory;
  try {
    if (const Result<> added = plugin->add(with_plugin); !added) {
      return fail(added.error().message);
    }
  } catch (const std::exception& error) {
    return fail(error.what());
  } catch (...) {
    return fail("it threw something that is not a std::exception");
  }
  factory = std::move(with_plugin);
  return Ok();
}

}  // namespace musher::tree
