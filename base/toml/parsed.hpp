#pragma once
// What became of a config file that was read.

#include <optional>
#include <vector>

#include "musher/base/diagnostic.hpp"

namespace musher {

template <class T>
struct Parsed {
  std::optional<T> config;              // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line; of this file, then of the files that it names
};

}  // namespace musher
