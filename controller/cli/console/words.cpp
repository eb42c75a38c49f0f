#include "musher/controller/cli/console/words.hpp"

#include <fmt/format.h>

namespace musher::cli {

std::string Join(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string Count(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace musher::cli
