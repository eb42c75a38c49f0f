#include "musher/cli/config/learned_times.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "musher/base/words.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

constexpr double kQuantile = 0.999;
constexpr double kLeastMarginMs = 100;      // of a limit above the 99.9th percentile
constexpr double kWorthChanging = 0.2;      // of the limit
constexpr double kDriftFactor = 1.5;        // or its inverse
constexpr double kLeastDriftMs = 20;        // what commands take is recorded in whole ms
constexpr std::size_t kLeastForDrift = 40;  // commands
constexpr double kCloseToLimit = 0.8;       // of the limit

// The smallest value that is not exceeded by that part of the values.
double Quantile(const std::vector<double>& sorted, double part) {
  const auto rank = static_cast<std::size_t>(std::ceil(part * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return Quantile(values, 0.5);
}

// Up to two digits that are not zero: 1,234 → 1,300.
double RoundedUp(double ms) {
  const double step = std::pow(10, std::max(0.0, std::floor(std::log10(ms)) - 1));
  return std::ceil(ms / step) * step;
}

// Of commands of one robot, by the time of their end.
std::optional<Drift> DriftOfRobot(const std::vector<const CommandTime*>& done) {
  if (done.size() < kLeastForDrift) return std::nullopt;
  const std::size_t newest = done.size() - done.size() / 4;
  std::vector<double> before;
  std::vector<double> after;
  for (std::size_t i = 0; i < done.size(); ++i) {
    (i < newest ? before : after).push_back(done[i]->took_ms);
  }
  const double now = Median(after);
  const double was = Median(before);
  if (std::abs(now - was) < kLeastDriftMs) return std::nullopt;
  const double factor = now / std::max(was, 1.0);
  if (factor < kDriftFactor && factor > 1 / kDriftFactor) return std::nullopt;
  return Drift{factor, done[newest]->wall_ns};
}

// The largest one of a robot. Robots are not compared: a slower one whose journal begins later has
// not changed.
std::optional<Drift> DriftOf(const std::vector<const CommandTime*>& done) {
  std::map<std::string, std::vector<const CommandTime*>> by_journal;
  for (const CommandTime* command : done) by_journal[command->journal].push_back(command);
  std::optional<Drift> most;
  for (const auto& [journal, commands] : by_journal) {
    auto drift = DriftOfRobot(commands);
    if (!drift || (most && most->factor >= drift->factor)) continue;
    if (by_journal.size() > 1) drift->journal = journal;
    most = std::move(drift);
  }
  return most;
}

std::optional<double> Proposed(const LearnedTime& row, const LearningOptions& options) {
  if (row.missing != 0 || !row.limit_ms) return std::nullopt;
  const double took_ms = row.state == kSetUp ? row.longest_ms : row.p999_ms;
  double limit = RoundedUp(std::max(took_ms * options.margin, took_ms + kLeastMarginMs));
  if (row.overdue > 0) limit = std::max(limit, *row.limit_ms);
  if (std::abs(limit - *row.limit_ms) <= kWorthChanging * *row.limit_ms) return std::nullopt;
  return limit;
}

LearnedTime RowOf(const std::vector<const CommandTime*>& all, const MachineConfig& config,
                  const LearningOptions& options) {
  LearnedTime row{all.front()->actuator, all.front()->state};
  if (const auto index = config.IndexOf(row.actuator)) {
    const auto limit = config.actuators[*index].TimeFor(row.state);
    if (limit) row.limit_ms = static_cast<double>(ToMilliseconds(*limit));
  }
  std::vector<const CommandTime*> done;
  std::vector<double> took;
  for (const CommandTime* command : all) {
    if (command->overdue) {
      ++row.overdue;
      row.overdue_at_limit += row.limit_ms && command->took_ms >= *row.limit_ms ? 1 : 0;
      continue;
    }
    done.push_back(command);
    took.push_back(command->took_ms);
  }
  row.commands = took.size();
  row.missing = options.least_commands - std::min(options.least_commands, took.size());
  if (took.empty()) return row;
  std::sort(took.begin(), took.end());
  row.median_ms = Quantile(took, 0.5);
  row.p999_ms = Quantile(took, kQuantile);
  row.longest_ms = took.back();
  row.proposed_ms = Proposed(row, options);
  if (row.proposed_ms) {
    const auto beyond = std::ranges::upper_bound(took, *row.proposed_ms);
    row.beyond_proposed = static_cast<std::size_t>(took.end() - beyond);
  }
  row.drift = DriftOf(done);
  return row;
}

// Where the config lists the state; behind all where it does not.
std::size_t PlaceOf(const LearnedTime& row, const MachineConfig& config) {
  const auto index = config.IndexOf(row.actuator);
  if (!index) return SIZE_MAX;
  const auto& states = config.actuators[*index].states;
  return static_cast<std::size_t>(std::find(states.begin(), states.end(), row.state) -
                                  states.begin());
}

std::string Line(const std::vector<std::int64_t>& times_ms) {
  return fmt::format("times = [{}]", fmt::join(times_ms, ", "));
}

}  // namespace

const char* LearnedTime::Noun() const {
  return state == kSetUp ? "start" : "command";
}

std::optional<double> LearnedTime::ShareOfLimit() const {
  if (missing != 0 || !limit_ms || *limit_ms <= 0) return std::nullopt;
  return p999_ms / *limit_ms;
}

std::vector<std::string> TimeWarnings(const std::vector<LearnedTime>& rows) {
  std::vector<std::string> warnings;
  for (const LearnedTime& row : rows) {
    if (!row.limit_ms) continue;
    const std::string state = row.actuator + ": " + row.state.name();
    if (row.overdue_at_limit != 0) {
      warnings.push_back(fmt::format(
          "{} was overdue in {} of {}, its limit is {:.0f} ms", state, row.overdue_at_limit,
          Counted(row.commands + row.overdue, row.Noun()), *row.limit_ms));
    } else if (row.ShareOfLimit().value_or(0) >= kCloseToLimit) {
      warnings.push_back(
          fmt::format("{} comes close to its limit: 99.9 % of {} took up to {:.0f} of {:.0f} ms",
                      state, Counted(row.commands, row.Noun()), row.p999_ms, *row.limit_ms));
    }
    if (row.drift && row.drift->factor > 1) {
      warnings.push_back(fmt::format("{} takes {:.1f} times as long since {}", state,
                                     row.drift->factor,
                                     LocalText(row.drift->since_wall_ns).substr(0, 16)));
    }
  }
  return warnings;
}

std::vector<LearnedTime> LearnTimes(const std::vector<CommandTime>& commands,
                                    const MachineConfig& config, const LearningOptions& options) {
  std::map<std::pair<std::string, State>, std::vector<const CommandTime*>> by_state;
  for (const CommandTime& command : commands) {
    by_state[{command.actuator, command.state}].push_back(&command);
  }
  std::vector<LearnedTime> rows;
  for (auto& [of, all] : by_state) {
    std::stable_sort(all.begin(), all.end(),
                     [](const auto* a, const auto* b) { return a->wall_ns < b->wall_ns; });
    rows.push_back(RowOf(all, config, options));
  }
  std::stable_sort(rows.begin(), rows.end(), [&](const LearnedTime& a, const LearnedTime& b) {
    return std::pair(a.actuator, PlaceOf(a, config)) < std::pair(b.actuator, PlaceOf(b, config));
  });
  return rows;
}

std::vector<std::int64_t> ProposedLimits(const ActuatorConfig& actuator,
                                         const std::vector<LearnedTime>& learned) {
  std::vector<std::int64_t> limits_ms;
  for (std::size_t i = 0; i < actuator.states.size(); ++i) {
    const auto row = std::find_if(learned.begin(), learned.end(), [&](const LearnedTime& one) {
      return one.actuator == actuator.name && one.state == actuator.states[i] && one.proposed_ms;
    });
    limits_ms.push_back(row != learned.end() ? static_cast<std::int64_t>(*row->proposed_ms)
                                             : ToMilliseconds(actuator.times[i]));
  }
  return limits_ms;
}

std::string ProposedTimes(const ActuatorConfig& actuator, const std::vector<LearnedTime>& learned) {
  std::string line = Line(ProposedLimits(actuator, learned));
  return line == TimesLine(actuator) ? "" : line;
}

std::string TimesLine(const ActuatorConfig& actuator) {
  return Line(ProposedLimits(actuator, {}));
}

}  // namespace musher::cli
