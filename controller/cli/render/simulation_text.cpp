#include <fmt/format.h>

#include "musher/controller/cli/console.hpp"
#include "musher/controller/cli/render/simulation.hpp"

namespace musher::cli {
namespace {

using simulation::Promise;
using simulation::Summary;

// 1234567 as "1,234,567".
std::string Grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

std::string Only(const simulation::StoryId& id) {
  std::string only;
  if (!id.only) return only;
  for (const std::size_t number : *id.only) {
    only += (only.empty() ? " --only " : ",") + std::to_string(number);
  }
  return only;
}

std::string Figures(const SimulationReport& report) {
  const Summary& s = report.summary;
  const double took = std::max(Seconds(report.took), 1e-9);
  std::uint64_t faults = 0;
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < simulation::kIncidentKinds; ++i) {
    const auto kind = static_cast<simulation::IncidentKind>(i);
    all += s.coverage.Of(kind);
    if (IsFault(kind)) faults += s.coverage.Of(kind);
  }
  std::string text =
      fmt::format("  lived     {} stories, {:.1f} robot-hours, in {:.1f} s: {} stories a minute\n",
                  Grouped(s.stories), Seconds(s.simulated) / 3600, took,
                  Grouped(static_cast<std::uint64_t>(static_cast<double>(s.stories) / took * 60)));
  text += "  switches ";
  for (std::size_t i = 0; i < s.switches.size(); ++i) {
    text +=
        fmt::format(" {} {}{}", Grouped(s.switches[i]), OutcomeName(static_cast<SwitchOutcome>(i)),
                    i + 1 < s.switches.size() ? "," : "\n");
  }
  text += fmt::format("  befell    {} incidents, {} of them faults; judged {} times\n",
                      Grouped(all), Grouped(faults), Grouped(s.judgements));
  if (!s.rests.empty()) {
    const auto at = [&](double share) {
      return Seconds(
          s.rests[static_cast<std::size_t>(share * static_cast<double>(s.rests.size() - 1))]);
    };
    text += fmt::format(
        "  at rest   {:.1f} s after the last fault (median), {:.1f} s (99 %), {:.1f} s (longest); "
        "bound {:.0f} s\n",
        at(0.5), at(0.99), at(1), Seconds(report.options.bound));
  }
  return text;
}

std::string Promises(const Summary& s, bool colour) {
  std::string text;
  for (std::size_t i = 0; i < simulation::kPromises; ++i) {
    const auto& bad = s.bad[i];
    text += bad.empty() ? Paint("  kept    ", Style::kGood, colour)
                        : Paint("  BROKEN  ", Style::kBad, colour);
    text += PromiseText(static_cast<Promise>(i));
    if (!bad.empty()) {
      text += fmt::format(": {} {}, seed {} first", Grouped(bad.size()),
                          bad.size() == 1 ? "story" : "stories", bad.front());
    }
    text += "\n";
  }
  return text;
}

std::string Verdict(const SimulationReport& report, bool colour) {
  if (report.summary.good()) {
    return Paint("Every story ends well.", Style::kGood, colour) + "\n";
  }
  std::uint64_t bad = 0;
  bool ours = false;
  for (std::size_t i = 0; i < simulation::kPromises; ++i) {
    bad += report.summary.bad[i].size();
    ours |= !report.summary.bad[i].empty() && !DependsOnConfig(static_cast<Promise>(i));
  }
  std::string text =
      fmt::format("{} of {} stories end badly.", Grouped(bad), Grouped(report.summary.stories));
  text = Paint(text, Style::kBad, colour) + "\n";
  if (ours) text += "A promise of Musher itself is broken: please report it with this config.\n";
  return text;
}

}  // namespace

std::string SimulationText(const SimulationReport& report, const std::string& bad_story,
                           bool colour) {
  std::string text = fmt::format("{}: {} actuators, {} stories\n\n", Printable(report.file),
                                 report.config.actuators.size(), Grouped(report.summary.stories));
  text += Figures(report);
  if (!report.others.empty()) {
    text += fmt::format("  note      simulated as if they spoke Musher's protocol: {}\n",
                        fmt::join(report.others, ", "));
  }
  text += "\nWhat befell the robot, and what it was doing then:\n\n" +
          report.summary.coverage.Text() + "\n";
  text += Promises(report.summary, colour) + "\n";
  if (report.worst) {
    text += fmt::format("The shortest bad story: musher simulate {} --seed {}{}\n\n{}\n",
                        Printable(report.file), report.worst->seed, Only(*report.worst), bad_story);
  }
  return text + Verdict(report, colour);
}

std::string StoryVerdict(const simulation::Ending& ending) {
  if (ending.violation) return "\nThis story ends badly.\n";
  return fmt::format("\nThis story ends well, {:.1f} s after the last fault.\n",
                     Seconds(ending.rested.value_or(Duration{})));
}

}  // namespace musher::cli
