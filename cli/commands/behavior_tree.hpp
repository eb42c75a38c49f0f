#pragma once
// `musher behavior NAME --tree`: the behaviour tree of a running application.

#include <cstdint>
#include <string>

#include "musher/cli/console/console.hpp"
#include "musher/cli/machine/link.hpp"

namespace musher::cli {

struct ShownTree {
  const std::string& name;    // of the actuator
  std::uint32_t history = 0;  // the newest so many changes
  bool entries = false;       // with the blackboards
  bool follow = false;        // every change, until Ctrl-C; redrawn on a terminal
};

ExitCode ShowTree(Link& link, const GlobalOptions& global, const ShownTree& shown,
                  Console& console);

}  // namespace musher::cli
