// musher prove FILE: every order of messages, callbacks, deadlines and faults of a robot with this
// config, on the real decision code. Touches no network and no process.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <iterator>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/base/memory_limit.hpp"
#include "musher/base/process_usage.hpp"
#include "musher/base/suggest.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/kept_searches.hpp"
#include "musher/cli/render/proof.hpp"

namespace musher::cli {
namespace {

constexpr int kMostFaults = 9;

struct ProveOptions {
  std::string file;
  int faults = 1;
  std::optional<double> budget_s;
  std::optional<double> memory_gb;  // 10^9 bytes
  std::string from;
  std::string to;      // with `replay`: what is requested; empty: the start
  std::string replay;  // the path of one scenario; empty: search
  std::string rules;   // file with rules of the user; empty: those of the config
  std::string svg;     // file for the drawing of the counter-example
  bool other_machine = false;
  bool resume = false;
  unsigned jobs = 0;  // threads; 0: one per core
};

constexpr double kBytesOfGb = 1e9;
constexpr double kLeastLeftGb = 0.25;  // of the computer's memory
// Of a limit; what is used grows between two looks at it.
constexpr double kOwnShare = 0.95;
constexpr double kGroupShare = 0.9;

// Three quarters of the computer's.
double UsualMemoryGb() {
  const auto pages = static_cast<double>(sysconf(_SC_PHYS_PAGES));
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / kBytesOfGb * 3 / 4;
}

double Gb(std::uint64_t bytes) {
  return static_cast<double>(bytes) / kBytesOfGb;
}

std::string Number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

// Shows the progress, and ends the proof when its time or memory is used up, or by Ctrl-C.
class ProofWatch {
 public:
  ProofWatch(const ProveOptions& options, Console& console)
      : options_(options),
        console_(console),
        memory_gb_(options.memory_gb.value_or(UsualMemoryGb())) {}

  std::string operator()(const search::ProofProgress& progress) {
    const auto now = std::chrono::steady_clock::now();
    if (progress.faults != faults_) {
      faults_ = progress.faults;
      begun_with_faults_ = now;
    }
    console_.ShowBlock(ProofProgressLine(progress, now - begun_with_faults_));
    if (NextSignal(signals_) != 0) {
      interrupted_ = true;
      return "it was interrupted";
    }
    if (options_.budget_s && ToSeconds(now - begun_) >= *options_.budget_s) {
      return "its budget of " + Number(*options_.budget_s) + " s is used up";
    }
    return WhyMemoryEnds();
  }

  Duration took() const { return std::chrono::steady_clock::now() - begun_; }
  bool interrupted() const { return interrupted_; }

 private:
  std::string WhyMemoryEnds() const {
    const auto usage = UsageOf(getpid());
    const double used_gb = usage ? Gb(usage->resident_bytes) : 0;
    if (used_gb >= memory_gb_ * kOwnShare) {
      return "it has used " + Number(memory_gb_) + " GB of memory (--memory permits more)";
    }
    if (group_ && used_gb >= Gb(*group_) * kGroupShare) {
      return "its control group permits " + Number(Gb(*group_)) + " GB of memory";
    }
    const auto left = AvailableMemory();
    if (left && Gb(*left) < kLeastLeftGb) {
      return "this computer has only " + Number(Gb(*left)) + " GB of memory left";
    }
    return {};
  }

  const ProveOptions& options_;
  Console& console_;
  const double memory_gb_;
  const std::optional<std::uint64_t> group_ = MemoryLimitOfGroups();
  const UniqueFd signals_ = TakeEndSignals();  // before the threads of the search
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point begun_with_faults_ = begun_;
  int faults_ = 0;
  bool interrupted_ = false;
};

// The finished searches of a proof, in a file, so that --resume does not make them again. A proof
// that ends by itself sooner than kKeepPeriod writes nothing.
class FinishedSearches {
 public:
  FinishedSearches(const MachineConfig& config, const search::ProofOptions& proof, Console& console)
      : config_(config), proof_(proof), console_(console) {}

  // The searches of earlier runs. Prints why there are none.
  std::vector<search::ProvedTask> Earlier() {
    if (!Open()) return {};
    const std::string all_made = "; all searches are made";
    if (!kept_->damage().empty()) {
      console_.PrintError("--resume: " + kept_->file() + ": " + kept_->damage() + all_made);
    } else if (kept_->earlier().empty()) {
      console_.PrintError(
          "--resume: no finished searches of this config, its rules and this build of Musher are "
          "kept" +
          all_made);
    }
    return kept_->earlier();
  }

  // Called with all that have finished so far.
  void operator()(const std::vector<search::ProvedTask>& finished) {
    const auto now = std::chrono::steady_clock::now();
    if (now - written_ < kKeepPeriod) return;
    written_ = now;
    Write(finished);
  }

  // The proof has ended. Returns how many --resume would not make again.
  std::size_t End(const search::Proof& proof) {
    std::vector<search::ProvedTask> finished;
    std::ranges::copy_if(proof.tasks, std::back_inserter(finished), &search::ProvedTask::finished);
    if (proof.end != search::ProofEnd::kNotFinished) {
      if (kept_) kept_->Remove(finished);
      return 0;
    }
    // It may have been interrupted before it took over those of an earlier run.
    if (finished.empty()) return kept_ ? EarlierOfThisProof() : 0;
    return Write(finished) ? finished.size() : 0;
  }

 private:
  static constexpr auto kKeepPeriod = std::chrono::seconds(10);

  // The file also has those from other states, and with more faults.
  std::size_t EarlierOfThisProof() const {
    const auto count = std::ranges::count_if(kept_->earlier(), [&](const auto& one) {
      const search::ProofTask& task = one.task;
      return task.faults <= proof_.faults && (!proof_.from || task.from == *proof_.from);
    });
    return static_cast<std::size_t>(count);
  }

  // Reads this program, which takes a moment.
  bool Open() {
    if (kept_ || failed_) return kept_.has_value();
    auto opened = KeptSearches::Open(config_, proof_);
    if (!opened) return Fail(opened.error());
    kept_ = std::move(opened).value();
    return true;
  }

  bool Write(const std::vector<search::ProvedTask>& finished) {
    if (!Open()) return false;
    const auto written = kept_->Keep(finished);
    return written || Fail(written.error());
  }

  // Returns false.
  bool Fail(const Error& error) {
    if (!failed_) console_.PrintError("finished searches are not kept: " + error.message);
    failed_ = true;
    return false;
  }

  const MachineConfig& config_;
  const search::ProofOptions& proof_;
  Console& console_;
  std::optional<KeptSearches> kept_;
  bool failed_ = false;
  std::chrono::steady_clock::time_point written_ = std::chrono::steady_clock::now();
};

ExitCode ExitOf(search::ProofEnd end) {
  switch (end) {
    case search::ProofEnd::kProved:
      return ExitCode::kDone;
    case search::ProofEnd::kViolated:
      return ExitCode::kNotDone;
    case search::ProofEnd::kNotFinished:
      break;
  }
  return ExitCode::kUnknownEnd;
}

// The report is printed already, and its exit code counts.
void DrawCounterExample(const ProofReport& report, const std::string& file, Console& console) {
  if (!report.proof.counter_example || file.empty()) return;
  const auto written = WriteFile(file, CounterExampleSvg(report));
  if (!written) console.PrintError("--svg: " + written.error().message);
}

// Of the value of --replay; empty: none.
std::string ReplayError(const std::string& text) {
  if (search::IsPath(text)) return "";
  return "'" + text.substr(0, 40) + "' is not the path of a scenario, as in 0.3.1";
}

// Runs the scenario of --replay.
ExitCode ReplayOne(const ProveOptions& options, const search::ProofOptions& proof,
                   ProofReport& report, Console& console) {
  const MachineConfig& config = report.config;
  if (options.from.empty() != options.to.empty()) {
    return console.Fail(
        Error{kCodeParametersInvalid,
              "--replay of a switch needs --from and --to, that of the start neither"});
  }
  if (!options.to.empty() && !config.HasState(options.to)) {
    return console.Fail(Error{kCodeParametersInvalid, "--to: " + config.name + " has no state '" +
                                                          options.to + "'" +
                                                          DidYouMean(options.to, config.states)});
  }
  const search::ProofTask task{State(options.from), State(options.to), options.faults};
  const MachineConfig searched = search::SearchableConfig(config);
  auto example = search::Replay(searched, proof, task, options.replay);
  if (!example) return console.Fail(example.error());
  const bool violated = !example.value().violations.empty();
  report.proof.counter_example = std::move(example).value();
  console.Print(console.mode().json ? ReplayedJson(report) : ReplayedText(report));
  DrawCounterExample(report, options.svg, console);
  return violated ? ExitCode::kNotDone : ExitCode::kDone;
}

ExitCode Prove(const ProveOptions& options, const GlobalOptions& /*global*/, Console& console) {
  const auto config = LoadConfig(options.file, console);
  if (!config) return ExitCode::kUsage;
  search::ProofOptions proof;
  proof.faults = options.faults;
  proof.other_machine = options.other_machine;
  if (!options.from.empty()) proof.from = State(options.from);
  UserRules rules;
  if (!LoadUserRules(options.rules, *config, console, rules)) return ExitCode::kUsage;
  proof.stable_rules = rules.stable;
  proof.timed_rules = rules.timed;
  const std::string why_not = search::WhyNotSearchable(*config, proof.from);
  if (!why_not.empty()) return console.Fail(Error{kCodeParametersInvalid, why_not});
  proof.threads =
      options.jobs == 0 ? std::max(1U, std::thread::hardware_concurrency()) : options.jobs;

  ProofReport report{*config, options.file, options.faults, options.from, {}, {}, {}, {}};
  report.rules_file = options.rules;
  report.other_machine = options.other_machine;
  if (!options.rules.empty() || !config->rules_file.empty()) report.rules = rules.size();
  report.user_rules = std::move(rules);
  if (!options.replay.empty()) return ReplayOne(options, proof, report, console);
  const MachineConfig searched = search::SearchableConfig(*config);
  FinishedSearches finished(*config, proof, console);
  if (options.resume) proof.earlier = finished.Earlier();
  ProofWatch watch(options, console);
  proof.on_progress = std::ref(watch);
  proof.on_finished = std::ref(finished);
  report.proof = search::Prove(searched, proof);
  report.took = watch.took();
  report.kept = finished.End(report.proof);
  console.HideBlock();
  console.Print(console.mode().json ? ProofJson(report) : ProofText(report, console.mode().colour));
  DrawCounterExample(report, options.svg, console);
  const bool ended = report.proof.end != search::ProofEnd::kNotFinished;
  return watch.interrupted() && !ended ? ExitCode::kInterrupted : ExitOf(report.proof.end);
}

}  // namespace

void AddProve(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("prove", "Search every order of events and faults of a state config", Prove,
                  "musher prove robot.toml --faults 1 --budget 600");
  grammar.Offer(app.add_option("FILE", options.file, "The state config"), Names::kConfigs)
      ->required()
      ->type_name("");
  app.add_option("--faults", options.faults, "Faults in a scenario at most; default 1")
      ->check(CLI::Range(0, kMostFaults).description(""))
      ->type_name("K");
  auto* replay = app.add_option("--replay", options.replay,
                                "Repeat and show one scenario, as a counter-example names it")
                     ->check(ReplayError)
                     ->type_name("PATH");
  app.add_flag("--resume", options.resume, "Skip the searches that an earlier run has finished")
      ->excludes(replay);
  app.add_option("--budget", options.budget_s, "End after this time; default: none")
      ->check(Between(0.001, 1e9, "seconds"))
      ->type_name("SECONDS");
  app.add_option("--memory", options.memory_gb,
                 "End when it uses so much memory;\ndefault: three quarters of the computer's")
      ->check(Between(0.001, 1e6, "GB"))
      ->type_name("GB");
  grammar
      .Offer(app.add_option("--from", options.from, "Search only what begins in this state"),
             Names::kStates)
      ->type_name("STATE");
  grammar
      .Offer(app.add_option("--to", options.to, "With --replay: the state that is requested"),
             Names::kStates)
      ->needs(replay)
      ->type_name("STATE");
  grammar
      .Offer(app.add_option("--rules", options.rules,
                            "Rules of your own, as in\n"
                            "never lamp Active while base is not Active,\n"
                            "within 5 s of Error arm in DeActive;\n"
                            "default: those that the config names"),
             Names::kFiles)
      ->type_name("FILE");
  app.add_flag("--other-machine", options.other_machine,
               "Faults are also a command to Active and a release of the\n"
               "stop by another machine, and a heartbeat of a controller\n"
               "that was replaced");
  grammar.Offer(app.add_option("--svg", options.svg, "Draw the counter-example"), Names::kFiles)
      ->type_name("FILE");
  app.add_option("-j,--jobs", options.jobs, "Threads; default all cores")
      ->check(CLI::Range(1U, 256U).description(""))
      ->type_name("N");
}

}  // namespace musher::cli
