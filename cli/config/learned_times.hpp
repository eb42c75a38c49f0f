#pragma once
// Limits for `times` of a state config, learned from what commands took in the journals of robots.
// Pure.
//
// A limit is the 99.9th percentile of what a state took, and a margin. It is never proposed lower
// while commands were overdue: how long those would have taken is not known. That of SetUp is not
// below the longest start and the margin: the few after a boot are the slow ones.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

// A command, or a start (the SetUp of a process), that has ended.
struct CommandTime {
  std::string actuator;
  State state;               // its target
  std::int64_t wall_ns = 0;  // when it ended, since 1970
  double took_ms = 0;
  bool overdue = false;      // it was not done by then
  std::string journal = {};  // its file: each is of one robot
};

struct LearningOptions {
  std::size_t least_commands = 100;  // fewer: no limit is proposed
  double margin = 1.5;               // times the 99.9th percentile
};

// That a state takes another time than before.
struct Drift {
  double factor = 1;               // the median of the newest quarter by that of the others
  std::int64_t since_wall_ns = 0;  // the begin of that quarter
  std::string journal = {};        // its file; empty: there is only one
};

struct LearnedTime {
  std::string actuator;
  State state;
  std::size_t commands = 0;  // that were done
  std::size_t overdue = 0;
  double median_ms = 0;
  double p999_ms = 0;
  double longest_ms = 0;
  std::optional<double> limit_ms{};     // in the config; none: it has no such actuator or state
  std::optional<double> proposed_ms{};  // none: too few commands, or the limit is right
  std::size_t missing = 0;              // commands until a limit is proposed
  std::optional<Drift> drift{};
  std::size_t beyond_proposed = 0;   // of the commands: longer than the proposed limit
  std::size_t overdue_at_limit = 0;  // of the overdue ones: the others had a shorter limit then

  const char* Noun() const;  // "command", of SetUp "start"
  // The 99.9th percentile divided by the limit; none: there is no limit, or too few commands.
  std::optional<double> ShareOfLimit() const;
};

// A row for each actuator and state with a command, by name and then as the config lists the
// states.
std::vector<LearnedTime> LearnTimes(const std::vector<CommandTime>& commands,
                                    const MachineConfig& config, const LearningOptions& options);

// A sentence for each state whose commands were overdue with its present limit, came close to it,
// or take longer than before. States that the config does not list have none.
std::vector<std::string> TimeWarnings(const std::vector<LearnedTime>& rows);

// The limits of an actuator's states in ms, in their order: the proposed ones, and the others as
// they are.
std::vector<std::int64_t> ProposedLimits(const ActuatorConfig& actuator,
                                         const std::vector<LearnedTime>& learned);
// The line `times = [...]` of an actuator with the proposed limits; empty: none of its differs.
std::string ProposedTimes(const ActuatorConfig& actuator, const std::vector<LearnedTime>& learned);
// The line as it is.
std::string TimesLine(const ActuatorConfig& actuator);

}  // namespace musher::cli
