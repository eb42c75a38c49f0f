#include <fmt/format.h>

#include <algorithm>

#include "musher/base/words.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/render/grouped.hpp"
#include "musher/cli/render/proof.hpp"
#include "musher/cli/render/rule_coverage.hpp"
#include "musher/simulation/timeline.hpp"

namespace musher::cli {
namespace {

using search::CounterExample;
using search::PathStep;
using search::ProofEnd;
using search::World;
using simulation::Timeline;

std::string TookText(Duration time) {
  const double seconds = ToSeconds(time);
  if (seconds < 100) return fmt::format("{:.1f} s", seconds);
  return fmt::format("{:.0f} min", seconds / 60);
}

// "for 1 fault", "without a fault"
std::string WithFaults(const std::string& preposition, int faults) {
  if (faults == 0) return "without a fault";
  return preposition + " " + Counted(static_cast<std::size_t>(faults), "fault");
}

// Where the searches begin, if not everywhere.
std::string Scope(const ProofReport& report) {
  return report.from.empty() ? "" : ", from " + Printable(report.from) + " alone";
}

// A sentence of the search as a line of the timeline.
Timeline::Line TimelineLine(std::string sentence, Duration at) {
  Timeline::Line line{at, Timeline::Source::kActuator, {}};
  for (const std::string_view fault : {"FAULT: ", "CROSSED "}) {
    if (!sentence.starts_with(fault)) continue;
    line.source = Timeline::Source::kInjection;
    sentence.erase(0, fault == "FAULT: " ? fault.size() : 0);
    if (fault == "CROSSED ") sentence.replace(0, fault.size(), "crossed ");
  }
  if (sentence.starts_with("a caller ") || sentence.starts_with("a person ")) {
    line.source = Timeline::Source::kOperator;
  } else if (sentence.starts_with("  ")) {
    sentence.erase(0, 2);
    if (sentence.find(" begins ") == std::string::npos) {
      line.source = Timeline::Source::kController;
    }
  }
  line.text = std::move(sentence);
  return line;
}

// The lines and bands of a counter-example. Time stands still between two deadlines: each event is
// drawn a microsecond after the one before it.
class Picture {
 public:
  Picture(const MachineConfig& config, const CounterExample& example) : config_(config) {
    bands_.push_back({"machine", {}});
    for (const ActuatorConfig& actuator : config.actuators) bands_.push_back({actuator.name, {}});
    Show(example.root);
    for (const PathStep& step : example.steps) {
      end_ = std::max(end_ + std::chrono::microseconds(1), step.world.now - example.root.now);
      for (const std::string& sentence : step.sentences)
        lines_.push_back(TimelineLine(sentence, end_));
      Show(step.world);
    }
    for (const std::string& violation : example.violations) {
      lines_.push_back({end_, Timeline::Source::kChecker, violation});
    }
    end_ += std::chrono::microseconds(1);
    for (Timeline::Band& band : bands_) band.spans.back().to = end_;
  }

  std::string Text() const { return Timeline::TextOf(lines_); }
  std::string Svg(const std::string& title) const {
    return Timeline::SvgOf(config_, lines_, bands_, end_, title);
  }

 private:
  void Show(const World& world) {
    const auto& current = world.machine.current;
    Show(0, world.machine.state, current ? current->target : State());
    for (const ActuatorIndex i : world.actuators.Indices()) {
      const search::SimActuator& actuator = world.actuators[i];
      const ActuatorReport& report = actuator.core.report;
      Show(i.value() + 1, actuator.alive ? report.state : State(),
           actuator.alive && report.busy() ? report.target : State());
    }
  }
  void Show(std::size_t band, const State& state, const State& target) {
    std::vector<Timeline::Span>& spans = bands_[band].spans;
    if (!spans.empty()) {
      spans.back().to = end_;
      if (spans.back().state == state.name() && spans.back().target == target.name()) return;
    }
    spans.push_back({end_, end_, state, target});
  }

  const MachineConfig& config_;
  std::vector<Timeline::Line> lines_;
  std::vector<Timeline::Band> bands_;
  Duration end_{};
};

// What was searched with each number of faults.
std::string Levels(const ProofReport& report) {
  std::string text;
  for (int faults = 0; faults <= report.faults; ++faults) {
    search::Figures figures;
    std::size_t finished = 0;
    std::size_t begun = 0;
    for (const search::ProvedTask& task : report.proof.tasks) {
      if (task.task.faults != faults) continue;
      figures += task.figures;
      ++begun;
      finished += task.finished ? 1 : 0;
    }
    if (begun == 0) continue;
    text += fmt::format("  {:<9} {}, {} complete; {} states, {} transitions\n",
                        Counted(static_cast<std::size_t>(faults), "fault"),
                        begun == 1 ? "1 search" : std::to_string(begun) + " searches", finished,
                        Grouped(figures.nodes), Grouped(figures.transitions));
  }
  return text;
}

// The searches that were not finished, the first ones by name.
std::string Left(const ProofReport& report) {
  constexpr std::size_t kMostNamed = 3;
  const std::vector<search::ProofTask>& left = report.proof.left;
  if (report.proof.end != ProofEnd::kNotFinished || left.empty()) return "";
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(left.size(), kMostNamed); ++i) {
    names.push_back(left[i].Text());
  }
  if (left.size() > kMostNamed) {
    names.push_back(Grouped(left.size() - kMostNamed) + " more");
  }
  return fmt::format("  note      not complete, {}: {}\n", WithFaults("with", left.front().faults),
                     fmt::join(names, "; "));
}

std::string Notes(const ProofReport& report) {
  std::string text = Left(report);
  const auto earlier = std::ranges::count_if(report.proof.tasks, &search::ProvedTask::earlier);
  if (earlier > 0) {
    text += fmt::format("  note      {} made by an earlier run\n",
                        earlier == 1 ? "1 search was" : std::to_string(earlier) + " searches were");
  }
  const std::vector<std::string> left_out = NotSearched(report);
  if (!left_out.empty()) {
    text += fmt::format("  note      not searched: {}\n", fmt::join(left_out, "; "));
  }
  if (!report.proof.not_reached.empty()) {
    std::vector<std::string> names;
    for (const State& state : report.proof.not_reached) names.push_back(state);
    text += fmt::format("  note      no request leads to {}: nothing is searched from there\n",
                        fmt::join(names, ", "));
  }
  return text;
}

// The first words of a command about the proof's config, with the options that decide what is
// searched.
std::string ProveCommand(const ProofReport& report) {
  std::string command = "musher prove " + Printable(ShellWord(report.file));
  if (!report.rules_file.empty()) {
    command += " --rules " + Printable(ShellWord(report.rules_file));
  }
  if (report.other_machine) command += " --other-machine";
  return command;
}

std::string Continuation(const ProofReport& report) {
  const std::string command = ResumeCommand(report);
  if (command.empty()) return "";
  const std::string what = report.kept == 1
                               ? "The finished search is kept"
                               : fmt::format("The {} finished searches are kept", report.kept);
  return what + ". Continue: " + command + "\n";
}

std::string Conclusion(const ProofReport& report, bool colour) {
  const search::Proof& proof = report.proof;
  const std::string figures =
      fmt::format("{} states, {} transitions, in {}", Grouped(proof.figures.nodes),
                  Grouped(proof.figures.transitions), TookText(report.took));
  switch (proof.end) {
    case ProofEnd::kProved:
      return Paint("Proved " + WithFaults("for", report.faults), Style::kGood, colour) +
             Scope(report) + ": " + figures + ".\n";
    case ProofEnd::kViolated:
      return Paint("Violated " + WithFaults("with", proof.counter_example->task.faults),
                   Style::kBad, colour) +
             ": " + figures + ".\n" +
             (proof.why.empty() ? "" : "No shorter one was searched for: " + proof.why + ".\n");
    case ProofEnd::kNotFinished:
      break;
  }
  return Paint("Not finished", Style::kBusy, colour) + ": " + proof.why + "; " +
         (proof.proved_faults < 0 ? "nothing is proved"
                                  : "proved " + WithFaults("for", proof.proved_faults)) +
         "; " + figures + ".\n" + Continuation(report);
}

}  // namespace

std::vector<std::string> NotSearched(const ProofReport& report) {
  std::vector<std::string> left_out = search::LeftOutOf(report.config);
  if (!report.user_rules.timed.empty() && report.faults > 0) {
    left_out.emplace_back(
        "for rules with a time, with a fault: callbacks that take some of their time (`musher "
        "simulate` has them), not none or all of it");
  }
  if (!report.other_machine) {
    left_out.emplace_back("messages of another machine (--other-machine searches three kinds)");
  }
  return left_out;
}

std::string CounterExampleText(const ProofReport& report) {
  return Picture(report.config, *report.proof.counter_example).Text();
}

std::string CounterExampleSvg(const ProofReport& report) {
  const CounterExample& example = *report.proof.counter_example;
  return Picture(report.config, example).Svg(report.config.name + ", " + example.task.Text());
}

std::string ReplayCommand(const ProofReport& report) {
  constexpr std::size_t kMostEvents = 500;
  const CounterExample& example = *report.proof.counter_example;
  if (example.path.empty() || example.choices > kMostEvents) return "";
  std::string command = ProveCommand(report);
  if (!example.task.IsStart()) {
    command += " --from " + Printable(ShellWord(example.task.from.name())) + " --to " +
               Printable(ShellWord(example.task.to.name()));
  }
  return command + fmt::format(" --faults {} --replay {}", example.task.faults, example.path);
}

std::string ResumeCommand(const ProofReport& report) {
  if (report.kept == 0) return "";
  std::string command = ProveCommand(report);
  if (!report.from.empty()) command += " --from " + Printable(ShellWord(report.from));
  return command + fmt::format(" --faults {} --resume", report.faults);
}

std::string ReplayedText(const ProofReport& report) {
  const CounterExample& example = *report.proof.counter_example;
  const std::string verdict = example.violations.empty() ? "no rule" : "a rule";
  return fmt::format("{}, {}, {}:\n\n{}\nThis scenario violates {}.\n", Printable(report.file),
                     example.task.Text(), WithFaults("up to", example.task.faults),
                     CounterExampleText(report), verdict);
}

std::string ProofText(const ProofReport& report, bool colour) {
  const search::Proof& proof = report.proof;
  std::string text = fmt::format(
      "{}: {}, {}, {}{}{}\n\n", Printable(report.file),
      Counted(report.config.actuators.size(), "actuator"), Counted(proof.reached.size(), "state"),
      report.rules ? Counted(*report.rules, "rule") + " of your own, " : "",
      WithFaults("up to", report.faults), Scope(report));
  text +=
      Levels(report) + Notes(report) +
      RuleCoverageText(report.config, report.user_rules,
                       {proof.rule_coverage, proof.timed_coverage}, CheckedIn::kSearch, colour) +
      "\n";
  if (proof.counter_example) {
    const bool is_shortest = proof.why.empty() && !proof.counter_example->repeats;
    const std::string shortest = is_shortest ? "The shortest" : "A";
    text += shortest + " counter-example, " + proof.counter_example->task.Text() + ":\n\n" +
            CounterExampleText(report) + "\n";
    const std::string command = ReplayCommand(report);
    if (!command.empty()) text += "Replay it: " + command + "\n\n";
  }
  return text + Conclusion(report, colour);
}

std::string ProofProgressLine(const search::ProofProgress& progress, Duration took) {
  if (progress.all == 0) return "finding the states that requests lead to";
  std::string line = fmt::format("{}: {} of {} searches, {} states",
                                 Counted(static_cast<std::size_t>(progress.faults), "fault"),
                                 progress.done, progress.all, Grouped(progress.states));
  constexpr double kTooEarly = 0.02;
  if (progress.share < kTooEarly) return line;
  const double left_s = ToSeconds(took) * (1 - progress.share) / progress.share;
  return line + ", about " + TookText(FromSeconds(left_s)) + " left";
}

}  // namespace musher::cli
