#include <nlohmann/json.hpp>

#include "musher/cli/console/json_line.hpp"
#include "musher/cli/render/proof.hpp"
#include "musher/cli/render/rule_coverage.hpp"

namespace musher::cli {
namespace {

std::string_view ResultName(search::ProofEnd end) {
  switch (end) {
    case search::ProofEnd::kProved:
      return "proved";
    case search::ProofEnd::kViolated:
      return "violated";
    case search::ProofEnd::kNotFinished:
      break;
  }
  return "not finished";
}

OrderedJson StateNames(const std::vector<State>& states) {
  OrderedJson names = OrderedJson::array();
  for (const State& state : states) names.push_back(state.name());
  return names;
}

// Of the start both states are null.
OrderedJson TaskOf(const search::ProofTask& task) {
  return {
      {"from", Known(task.from.name())}, {"to", Known(task.to.name())}, {"faults", task.faults}};
}

}  // namespace

std::string ProofJson(const ProofReport& report) {
  const search::Proof& proof = report.proof;
  OrderedJson json = {
      {"file", report.file},
      {"faults", report.faults},
      {"from", Known(report.from)},
      {"rules", report.rules ? OrderedJson(*report.rules) : OrderedJson()},
      {"left_out", NotSearched(report)},
      {"result", ResultName(proof.end)},
      {"proved_faults", proof.proved_faults < 0 ? OrderedJson() : OrderedJson(proof.proved_faults)},
      {"why", Known(proof.why)},
      {"states", proof.figures.nodes},
      {"transitions", proof.figures.transitions},
      {"took_s", ToSeconds(report.took)},
      {"reached", StateNames(proof.reached)},
      {"not_reached", StateNames(proof.not_reached)},
      {"resume", Known(ResumeCommand(report))},
      {"searches", OrderedJson::array()}};
  for (const search::ProvedTask& task : proof.tasks) {
    OrderedJson search = TaskOf(task.task);
    search["states"] = task.figures.nodes;
    search["transitions"] = task.figures.transitions;
    search["complete"] = task.finished;
    search["earlier_run"] = task.earlier;
    json["searches"].push_back(std::move(search));
  }
  json["rule_coverage"] = nullptr;
  if (report.rules) {
    json["rule_coverage"] =
        RuleCoverageJson(report.user_rules, {proof.rule_coverage, proof.timed_coverage});
  }
  json["counter_example"] = nullptr;
  if (proof.counter_example) {
    json["counter_example"] = TaskOf(proof.counter_example->task);
    json["counter_example"]["violations"] = proof.counter_example->violations;
    json["counter_example"]["text"] = CounterExampleText(report);
    json["counter_example"]["replay"] = proof.counter_example->path;
  }
  return JsonLine(json);
}

std::string ReplayedJson(const ProofReport& report) {
  const search::CounterExample& example = *report.proof.counter_example;
  OrderedJson json = {{"file", report.file}};
  json.update(TaskOf(example.task));
  json["replay"] = example.path;
  json["violations"] = example.violations;
  json["text"] = CounterExampleText(report);
  return JsonLine(json);
}

}  // namespace musher::cli
