#pragma once
// The fault-injection suite's command line.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/fault_injection/kind.hpp"

namespace musher::fault_injection {

struct Options {
  int faults = 40;
  std::uint64_t seed = 1;
  std::string report = "fault-injection suite-report";
  std::vector<std::string> only;  // kinds or families
  bool list = false;
};

// A wrong command line; exit code 2.
struct Usage {
  std::string message;
};

// Throws Usage. Ends the program after --help.
Options ReadOptions(int argc, char** argv);

// Prints all kinds; gives the exit code.
int List();

struct Selection {
  std::vector<const Kind*> kinds;
  std::vector<std::string> skipped;  // a line for each reason
};

// What can be run here of what is asked for. Throws Usage when an unknown kind is, or one alone
// that this machine does not allow.
Selection Select(const Options& options, const Isolation& isolation);

}  // namespace musher::fault_injection
