// A shared library of the same version, whose headers were other ones.

#include "musher/behavior/tree/plugin/plugin.hpp"

namespace {

musher::Result<> AddNone(musher::tree::Factory& /*factory*/) {
  return musher::Ok();
}

constexpr musher::tree::PluginSizes OtherSizes() {
  musher::tree::PluginSizes sizes = musher::tree::kPluginSizes;
  sizes.back() += 8;
  return sizes;
}

}  // namespace

extern "C" __attribute__((visibility("default"), used))
const musher::tree::Plugin musher_tree_plugin = {
    MUSHER_TREE_PLUGIN_BUILD, musher::tree::TypeOf<double>(), OtherSizes(), &AddNone};
