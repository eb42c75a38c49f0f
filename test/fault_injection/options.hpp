#pragma once
// The command line of the fault-injection suite.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/fault_injection/kind.hpp"

namespace musher::fault_injection {

struct Options {
  int faults = 40;
  std::uint64_t seed = 1;
  std::string report = "fault_injection_report";
  std::vector<std::string> only;  // kinds or families
  bool list = false;
};

// An invalid command line; exit code 2.
struct Usage {
  std::string message;
};

// Throws Usage. Ends the program after --help.
Options ReadOptions(int argc, char** argv);

// Prints all kinds; returns the exit code.
int List();

struct Selection {
  std::vector<const Kind*> kinds;
  std::vector<std::string> skipped;  // a line for each reason
};

// The requested kinds that can run here. Throws Usage for an unknown kind, and for a kind requested
// by name that this machine does not permit.
Selection Select(const Options& options, const Isolation& isolation);

}  // namespace musher::fault_injection
