#include "musher/base/version.hpp"

namespace musher {

std::string_view Version() {
  return MUSHER_VERSION;
}

}  // namespace musher
