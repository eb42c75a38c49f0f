#include "musher/test/support/paths.hpp"

namespace musher {

std::string SourceDir() {
  return MUSHER_SOURCE_DIR;
}

std::string BinDir() {
  return MUSHER_BIN_DIR;
}

}  // namespace musher
