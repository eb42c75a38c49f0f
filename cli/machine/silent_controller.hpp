#pragma once
// A controller of this host that holds the name of a namespace and cannot be reached: why, and what
// to do.

#include <sys/types.h>

#include <optional>
#include <string>

#include "musher/cli/console/options.hpp"

namespace musher::cli {

struct SilentController {
  pid_t pid = 0;
  bool stopped = false;          // by a signal, as SIGSTOP
  std::optional<bool> security;  // whether its config has [security]; none: not known
  std::string file;              // its config or upgrade root; empty: not known
};

// `pid` leads the command's namespace.
SilentController ExamineSilent(pid_t pid, const GlobalOptions& global);

// "process 4711 leads it on this host but does not answer: it is stopped; `kill -CONT 4711` …"
std::string WhySilent(const SilentController& controller, const GlobalOptions& global);

}  // namespace musher::cli
