#include "musher/cli/render/rule_coverage.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "musher/base/words.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/render/grouped.hpp"

namespace musher::cli {
namespace {

template <class Coverage>
Coverage CoverageOfRule(const std::vector<Coverage>& coverage, std::size_t rule) {
  return rule < coverage.size() ? coverage[rule] : Coverage();
}

// "lamp is in Active", "base is exited"
std::string PlaceText(const MachineConfig& config, const StableRule::Place& place) {
  const std::string name =
      place.actuator ? config.actuators[*place.actuator].name : std::string("the machine");
  return name + (place.state.empty() ? " is exited" : " is in " + place.state);
}

std::string CoverageText(const MachineConfig& config, const StableRule& rule,
                         const RuleCoverage& c) {
  if (c.states == 0) return "no stable state was reached";
  const std::string place = PlaceText(config, rule.never);
  const std::string states = Grouped(c.states) + " " + NounOf(c.states, "stable state");
  if (!rule.condition) return fmt::format("{} in {} of {}", place, Grouped(c.forbidden), states);
  if (c.condition == 0) return "its condition holds in none of " + states;
  return fmt::format("its condition holds in {} of {}, and {} in {}", Grouped(c.condition), states,
                     place, Grouped(c.forbidden));
}

// A search branches: of one begin there are many ends.
std::string CoverageText(const TimedRule& rule, const TimedRuleCoverage& c, CheckedIn what) {
  if (c.begun == 0) return "the machine never goes to " + rule.of;
  if (what == CheckedIn::kSearch) {
    return fmt::format("its time begins in {} {}, and it is met in {}", Grouped(c.begun),
                       NounOf(c.begun, "transition"), Grouped(c.met));
  }
  return fmt::format("its time begins {} {}, and it is met in {} of them", Grouped(c.begun),
                     NounOf(c.begun, "time"), Grouped(c.met));
}

std::string CoverageLine(bool is_tested, const std::string& rule, const std::string& coverage,
                         bool colour) {
  return (is_tested ? "  rule      " : Paint("  UNTESTED  ", Style::kBusy, colour)) + rule + ": " +
         coverage + "\n";
}

// What is of the other kind of rules is null.
OrderedJson CoverageRow(const std::string& rule, bool is_tested) {
  return {{"rule", rule},         {"tested", is_tested},  {"stable_states", nullptr},
          {"condition", nullptr}, {"forbidden", nullptr}, {"begun", nullptr},
          {"met", nullptr}};
}

}  // namespace

std::string RuleCoverageText(const MachineConfig& config, const UserRules& rules,
                             const UserRulesCoverage& coverage, CheckedIn what, bool colour) {
  std::string text;
  for (std::size_t i = 0; i < rules.stable.size(); ++i) {
    const StableRule& rule = rules.stable[i];
    const RuleCoverage c = CoverageOfRule(coverage.stable, i);
    text += CoverageLine(c.condition > 0, rule.text, CoverageText(config, rule, c), colour);
  }
  for (std::size_t i = 0; i < rules.timed.size(); ++i) {
    const TimedRule& rule = rules.timed[i];
    const TimedRuleCoverage c = CoverageOfRule(coverage.timed, i);
    text += CoverageLine(c.begun > 0, rule.text, CoverageText(rule, c, what), colour);
  }
  return text;
}

OrderedJson RuleCoverageJson(const UserRules& rules, const UserRulesCoverage& coverage) {
  OrderedJson json = OrderedJson::array();
  for (std::size_t i = 0; i < rules.stable.size(); ++i) {
    const RuleCoverage c = CoverageOfRule(coverage.stable, i);
    OrderedJson row = CoverageRow(rules.stable[i].text, c.condition > 0);
    row["stable_states"] = c.states;
    if (rules.stable[i].condition) row["condition"] = c.condition;
    row["forbidden"] = c.forbidden;
    json.push_back(std::move(row));
  }
  for (std::size_t i = 0; i < rules.timed.size(); ++i) {
    const TimedRuleCoverage c = CoverageOfRule(coverage.timed, i);
    OrderedJson row = CoverageRow(rules.timed[i].text, c.begun > 0);
    row["begun"] = c.begun;
    row["met"] = c.met;
    json.push_back(std::move(row));
  }
  return json;
}

}  // namespace musher::cli
