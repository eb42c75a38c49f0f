#pragma once
// The report of `musher prove`, as text and as JSON.

#include <optional>
#include <string>
#include <vector>

#include "musher/search/proof.hpp"

namespace musher::cli {

struct ProofReport {
  const MachineConfig& config;
  std::string file;
  int faults = 1;                    // that were to be proved
  std::string from;                  // only what begins in this state; empty: all
  std::optional<std::size_t> rules;  // of the user, how many; none: no file of them
  search::Proof proof;
  Duration took{};
  std::string rules_file = {};  // empty: no --rules
  UserRules user_rules = {};
  bool other_machine = false;  // whether its messages are faults
  std::size_t kept = 0;        // of the searches, for --resume
};

// What is left out of the search: of the config, of the rules that it names, and of the faults.
std::vector<std::string> NotSearched(const ProofReport& report);
std::string ProofText(const ProofReport& report, bool colour);
std::string ProofJson(const ProofReport& report);
// The picture of the counter-example; there is one.
std::string CounterExampleSvg(const ProofReport& report);
// The counter-example, a line for each event.
std::string CounterExampleText(const ProofReport& report);
// The command that repeats the counter-example; empty: it has too many events to copy, or none.
std::string ReplayCommand(const ProofReport& report);
// The command that continues an interrupted proof; empty: nothing is kept for it.
std::string ResumeCommand(const ProofReport& report);
// The counter-example, which was replayed, and whether it still violates a rule.
std::string ReplayedText(const ProofReport& report);
std::string ReplayedJson(const ProofReport& report);

// "1 fault: 12 of 52 searches, 1,234,567 states, about 3 min left"; `took`: since the searches with
// so many faults began.
std::string ProofProgressLine(const search::ProofProgress& progress, Duration took);

}  // namespace musher::cli
