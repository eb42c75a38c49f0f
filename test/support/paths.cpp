#include "musher/test/support/paths.hpp"

namespace musher {

std::string SourceDir() {
  return MUSHER_SOURCE_DIR;
}

std::string BuildDir() {
  return MUSHER_BUILD_DIR;
}

std::string BinDir() {
  return BuildDir() + "/bin";
}

}  // namespace musher
