#include <fmt/format.h>

#include "musher/base/words.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/render/grouped.hpp"
#include "musher/cli/render/rule_coverage.hpp"
#include "musher/cli/render/simulation.hpp"

namespace musher::cli {
namespace {

using simulation::Invariant;
using simulation::Summary;

std::string Only(const simulation::ScenarioId& id) {
  std::string only;
  if (!id.only) return only;
  for (const std::size_t number : *id.only) {
    only += (only.empty() ? " --only " : ",") + std::to_string(number);
  }
  return only;
}

std::string Figures(const SimulationReport& report) {
  const Summary& s = report.summary;
  const double took = std::max(ToSeconds(report.took), 1e-9);
  std::uint64_t faults = 0;
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < simulation::kInjectionKinds; ++i) {
    const auto kind = static_cast<simulation::InjectionKind>(i);
    all += s.coverage.Of(kind);
    if (IsFault(kind)) faults += s.coverage.Of(kind);
  }
  std::string text = fmt::format(
      "  simulated {} scenarios, {:.1f} robot-hours, in {:.1f} s: {} scenarios a minute\n",
      Grouped(s.scenarios), ToSeconds(s.simulated) / 3600, took,
      Grouped(static_cast<std::uint64_t>(static_cast<double>(s.scenarios) / took * 60)));
  text += "  switches ";
  for (std::size_t i = 0; i < s.switches.size(); ++i) {
    text +=
        fmt::format(" {} {}{}", Grouped(s.switches[i]), OutcomeName(static_cast<SwitchOutcome>(i)),
                    i + 1 < s.switches.size() ? "," : "\n");
  }
  text += fmt::format("  injected  {} events, {} of them faults; {} checks\n", Grouped(all),
                      Grouped(faults), Grouped(s.checks));
  if (!s.rests.empty()) {
    const auto at = [&](double share) {
      return ToSeconds(
          s.rests[static_cast<std::size_t>(share * static_cast<double>(s.rests.size() - 1))]);
    };
    text += fmt::format(
        "  settled   {:.1f} s after the last fault (median), {:.1f} s (99 %), {:.1f} s (longest); "
        "bound {:.0f} s\n",
        at(0.5), at(0.99), at(1), ToSeconds(report.options.bound));
  }
  return text;
}

std::string Invariants(const SimulationReport& report, bool colour) {
  const Summary& s = report.summary;
  std::string text;
  for (std::size_t i = 0; i < simulation::kInvariants; ++i) {
    const bool of_user = static_cast<Invariant>(i) == Invariant::kUserRules;
    if (of_user && !report.has_rules()) continue;
    const auto& bad = s.bad[i];
    text += bad.empty() ? Paint("  holds     ", Style::kGood, colour)
                        : Paint("  VIOLATED  ", Style::kBad, colour);
    text += InvariantText(static_cast<Invariant>(i));
    if (of_user) text += " (" + Counted(report.options.rules.size(), "rule") + ")";
    if (!bad.empty()) {
      text += fmt::format(": {} {}, seed {} first", Grouped(bad.size()),
                          bad.size() == 1 ? "scenario" : "scenarios", bad.front());
    }
    text += "\n";
    if (!of_user) continue;
    text += RuleCoverageText(report.config, report.options.rules, s.rule_coverage,
                             CheckedIn::kSimulation, colour);
  }
  return text;
}

std::string Verdict(const SimulationReport& report, bool colour) {
  if (report.summary.good()) {
    return Paint("All scenarios passed.", Style::kGood, colour) + "\n";
  }
  std::uint64_t bad = 0;
  bool ours = false;
  for (std::size_t i = 0; i < simulation::kInvariants; ++i) {
    bad += report.summary.bad[i].size();
    ours |= !report.summary.bad[i].empty() && !DependsOnConfig(static_cast<Invariant>(i));
  }
  std::string text =
      fmt::format("{} of {} scenarios failed.", Grouped(bad), Grouped(report.summary.scenarios));
  text = Paint(text, Style::kBad, colour) + "\n";
  if (ours)
    text += "An invariant of Musher itself is violated: please report it with this config.\n";
  return text;
}

}  // namespace

std::string SimulationText(const SimulationReport& report, const std::string& failing_scenario,
                           bool colour) {
  std::string text =
      fmt::format("{}: {}, {} scenario{}\n\n", Printable(report.file),
                  Counted(report.config.actuators.size(), "actuator"),
                  Grouped(report.summary.scenarios), report.summary.scenarios == 1 ? "" : "s");
  text += Figures(report);
  if (!report.others.empty()) {
    text += fmt::format("  note      simulated with Musher's protocol instead of their own: {}\n",
                        fmt::join(report.others, ", "));
  }
  text +=
      "\nInjected events, by the phase of the machine:\n\n" + report.summary.coverage.Text() + "\n";
  text += Invariants(report, colour) + "\n";
  if (report.worst) {
    const std::string rules =
        report.rules.empty() ? "" : " --rules " + Printable(ShellWord(report.rules));
    text += fmt::format("The shortest failing scenario: musher simulate {}{} --seed {}{}\n\n{}\n",
                        Printable(ShellWord(report.file)), rules, report.worst->seed,
                        Only(*report.worst), failing_scenario);
  }
  return text + Verdict(report, colour);
}

std::string ScenarioVerdict(const simulation::ScenarioEnd& ending) {
  if (ending.violation) return "\nThis scenario failed.\n";
  return fmt::format(
      "\nThis scenario passed; the machine was stable {:.1f} s after the last fault.\n",
      ToSeconds(ending.rested.value_or(Duration{})));
}

}  // namespace musher::cli
