// musher-vp-engine: programs that a person makes of blocks. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/vp_engine/engine.hpp"

namespace {

int Run(const musher::program::Options& options) {
  return musher::program::RunModule<musher::vp_engine::Engine>(
      options, musher::vp_engine::ReadVpFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-vp-engine", "Runs programs that are behaviour trees, from a folder.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
