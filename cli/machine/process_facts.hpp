#pragma once
// A process of this host for people: what it was started as and what it uses.
//
// Threads: any; reads /proc.

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

#include "musher/base/process_usage.hpp"

namespace musher::cli {

struct ProcessFacts {
  ProcessUsage usage;
  std::string command;  // its words, with spaces
  std::string cwd;
  std::int64_t started_wall_ns = 0;
  double age_s = 0;
  bool stopped = false;  // by SIGSTOP or a debugger
};

// nullopt: there is no such process, or it is not visible to us.
std::optional<ProcessFacts> FactsOf(pid_t pid);

}  // namespace musher::cli
