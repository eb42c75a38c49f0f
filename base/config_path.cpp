#include "musher/base/config_path.hpp"

#include <cstdlib>

namespace musher {

std::string ConfigPath(const std::string& given) {
  if (!given.empty()) return given;
  const char* named = std::getenv("MUSHER_CONFIG");  // NOLINT(concurrency-mt-unsafe)
  return named != nullptr ? named : "";
}

}  // namespace musher
