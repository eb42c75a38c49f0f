#include <nlohmann/json.hpp>

#include "musher/cli/console/json_line.hpp"
#include "musher/cli/render/rule_coverage.hpp"
#include "musher/cli/render/simulation.hpp"

namespace musher::cli {
namespace {

OrderedJson ScenarioOf(const simulation::ScenarioId& id) {
  return {{"seed", id.seed}, {"only", id.only ? OrderedJson(*id.only) : OrderedJson()}};
}

OrderedJson CoverageOf(const simulation::Coverage& coverage) {
  OrderedJson json;
  for (std::size_t kind = 0; kind < simulation::kInjectionKinds; ++kind) {
    const auto injection = static_cast<simulation::InjectionKind>(kind);
    OrderedJson& row = json[std::string(KindName(injection))];
    for (std::size_t phase = 0; phase < simulation::kMachinePhases; ++phase) {
      const auto when = static_cast<simulation::MachinePhase>(phase);
      row[std::string(MachinePhaseName(when))] = coverage.Of(injection, when);
    }
  }
  return json;
}

}  // namespace

std::string SimulationJson(const SimulationReport& report, const std::string& failing_scenario) {
  const simulation::Summary& s = report.summary;
  OrderedJson json = {{"file", report.file},
                      {"scenarios", s.scenarios},
                      {"passed", s.good()},
                      {"simulated_s", ToSeconds(s.simulated)},
                      {"took_s", ToSeconds(report.took)},
                      {"checks", s.checks},
                      {"bound_s", ToSeconds(report.options.bound)},
                      {"rules", nullptr}};
  if (report.has_rules()) json["rules"] = report.options.rules.size();
  for (std::size_t i = 0; i < s.switches.size(); ++i) {
    json["switches"][std::string(OutcomeName(static_cast<SwitchOutcome>(i)))] = s.switches[i];
  }
  json["settled_s"] = nullptr;
  if (!s.rests.empty()) {
    json["settled_s"] = {{"median", ToSeconds(s.rests[s.rests.size() / 2])},
                         {"longest", ToSeconds(s.rests.back())}};
  }
  json["injected_events"] = CoverageOf(s.coverage);
  for (std::size_t i = 0; i < simulation::kInvariants; ++i) {
    const auto invariant = static_cast<simulation::Invariant>(i);
    if (invariant == simulation::Invariant::kUserRules && !report.has_rules()) continue;
    json["invariants"].push_back(
        {{"invariant", InvariantText(invariant)}, {"violated_by", s.bad[i]}});
  }
  json["rule_coverage"] = nullptr;
  if (report.has_rules()) {
    json["rule_coverage"] = RuleCoverageJson(report.options.rules, s.rule_coverage);
  }
  json["shortest_failing_scenario"] = nullptr;
  if (report.worst) {
    json["shortest_failing_scenario"] = ScenarioOf(*report.worst);
    json["shortest_failing_scenario"]["text"] = failing_scenario;
  }
  return JsonLine(json);
}

std::string ScenarioJson(const simulation::ScenarioId& id, const simulation::ScenarioEnd& ending,
                         const std::string& text) {
  OrderedJson json = ScenarioOf(id);
  json["passed"] = !ending.violation.has_value();
  json["violated"] = nullptr;
  json["what"] = nullptr;
  if (ending.violation) {
    json["violated"] = InvariantText(ending.violation->invariant);
    json["what"] = ending.violation->what;
  }
  json["text"] = text;
  return JsonLine(json);
}

}  // namespace musher::cli
