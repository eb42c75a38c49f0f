#pragma once
// The proof of a state config: the exhaustive search of its machine, from every state that the
// machine reaches to every state that its flow allows, and of its start; first without a fault,
// then with one, and so on.
//
// What the search leaves out of a config: LeftOutOf(). Actuators with `host` run on other hosts,
// all others on the controller's, in a process each; they speak Musher's protocol. docs/proof.md
// says what a proof is worth.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/search/explorer.hpp"

namespace musher::search {

// One search: a switch of the machine, or its start.
struct ProofTask {
  State from;  // where the machine is; of the start: empty
  State to;    // what is requested; of the start: empty
  int faults = 0;

  bool IsStart() const { return to.empty(); }
  std::string Text() const;  // "from Active to LowPower", "the start"

  friend bool operator==(const ProofTask&, const ProofTask&) = default;
};

struct ProvedTask {
  ProofTask task;
  Figures figures;
  bool finished = false;  // all was searched, without a violation
  bool earlier = false;   // by an earlier run
  // The coverage of each rule of the user: in the stable states of this search, in its transitions.
  std::vector<RuleCoverage> rule_coverage = {};
  std::vector<TimedRuleCoverage> timed_coverage = {};
};

// A scenario that violates a rule: of the fewest faults, and with these of the fewest choices, if
// there was time and memory to search for that one.
struct CounterExample {
  ProofTask task;
  std::string path;         // see explorer.hpp
  std::size_t choices = 0;  // of the path
  bool repeats = false;     // see Fault; such a one is not the shortest
  World root;
  std::vector<PathStep> steps;
  std::vector<std::string> violations;
};

struct ProofProgress {
  int faults = 0;          // the searches under way have so many
  std::size_t done = 0;    // searches with so many faults …
  std::size_t all = 0;     // … of so many; none yet while the states are found
  std::size_t states = 0;  // so far, of all searches
  double share = 0;        // of the work with so many faults, as searches with one fewer took
};

struct ProofOptions {
  int faults = 1;
  std::optional<State> from;  // search only what begins there
  unsigned threads = 1;
  std::vector<StableRule> stable_rules = {};  // of the user
  std::vector<TimedRule> timed_rules = {};    // of the user
  Rules rules = {};
  // Whether to search one of the states that differ by alike actuators only. By default off: it is
  // not exact where one step sends to two of them, and the controller is killed between the two.
  bool symmetry = false;
  // Whether one order of what commutes is searched (reduction.hpp); off: all.
  bool reduces = true;
  // Whether faults are also what another machine sends an actuator (a command to Active with a
  // higher epoch, a release of the stop), and a heartbeat with a lower epoch, of a controller that
  // was replaced. None arrives between two commands of one step.
  bool other_machine = false;
  // Called in the calling thread a few times a second. A text ends the proof, which is then not
  // finished because of it.
  std::function<std::string(const ProofProgress&)> on_progress = {};
  // Searches that an earlier run has finished, with the same config, rules, `other_machine`,
  // `symmetry` and decision code: they are not made again.
  std::vector<ProvedTask> earlier = {};
  // Called in the calling thread where searches have ended, with all that are finished by then,
  // those of an earlier run too. One that is interrupted is never among them.
  std::function<void(const std::vector<ProvedTask>&)> on_finished = {};
};

enum class ProofEnd : std::uint8_t { kProved, kViolated, kNotFinished };

struct Proof {
  ProofEnd end = ProofEnd::kNotFinished;
  std::string why;             // it is not finished, or no shorter scenario was searched for
  int proved_faults = -1;      // all was searched up to so many faults without a violation
  std::vector<State> reached;  // states, in the config's order
  // States that no sequence of requests without a fault leads to; but TearDown, its end.
  std::vector<State> not_reached;
  std::vector<ProvedTask> tasks;  // that were begun, and those of an earlier run
  std::vector<ProofTask> left;    // with the last number of faults, not finished or not begun
  Figures figures;                // of all
  // The coverage of each rule of the user, in the stable states of all searches. A state that
  // several searches reach counts in each.
  std::vector<RuleCoverage> rule_coverage;
  std::vector<TimedRuleCoverage> timed_coverage;  // of each with a time, in all transitions
  std::optional<CounterExample> counter_example;
};

// The machine as it is searched, without what the search leaves out.
MachineConfig SearchableConfig(const MachineConfig& config);

// What that is, of the keys of this config: "[policy]", "checkpoint_ms of camera, lidar".
std::vector<std::string> LeftOutOf(const MachineConfig& config);

// Why a config cannot be searched; empty: it can.
std::string WhyNotSearchable(const MachineConfig& config, const std::optional<State>& from);

// `config`: a searchable one.
Proof Prove(const MachineConfig& config, const ProofOptions& options);

// Whether it is a path: numbers of at most four digits with dots between them.
bool IsPath(std::string_view text);

// The scenario of this path, for which IsPath() holds, on the real decision code; no violations:
// every rule holds in it. Errors: the path has an event that is not possible, or ends before the
// machine is stable; it is not whole, or of another config or version.
Result<CounterExample> Replay(const MachineConfig& config, const ProofOptions& options,
                              const ProofTask& task, const std::string& path);

}  // namespace musher::search
