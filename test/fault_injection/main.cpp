// Injects faults into a robot of real processes, and checks detection, recovery and invariants:
//
//   fault_injection --faults 500 --seed 1 --report DIR [--only KIND]... [--list]
//
// Exit codes: 0 all checks hold, 1 a check failed, 2 usage, 130 interrupted.

#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/fault_injection/host/reaper.hpp"
#include "musher/test/fault_injection/options.hpp"
#include "musher/test/fault_injection/report/report.hpp"
#include "musher/test/fault_injection/robot/processes.hpp"
#include "musher/test/fault_injection/suite.hpp"

namespace musher::fault_injection {
namespace {

void Print(const Outcome& outcome, std::size_t number, std::size_t of) {
  std::printf("%3zu/%zu %-22s %6.2f s  %s\n", number, of, outcome.kind.c_str(),
              outcome.whole_ms / 1000, outcome.sampled.c_str());
  for (const std::string& failure : outcome.failures) {
    std::printf("        FAILED: %s\n", failure.c_str());
  }
  if (!outcome.failures.empty()) {
    std::printf("        replay: fault_injection --only %s --faults 1 --seed %llu\n",
                outcome.kind.c_str(), static_cast<unsigned long long>(outcome.seed));
  }
  std::fflush(stdout);
}

void InterruptBySignal(int) {
  Interrupt();
}

// A signal ends the run in order: the report is written, all processes and files are removed.
void WatchSignals() {
  struct sigaction action {};
  action.sa_handler = InterruptBySignal;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

int Main(const Options& options) {
  const Isolation isolation = Isolate();
  const Reaper reaper;
  AdoptOrphans();
  WatchSignals();
  const Selection selection = Select(options, isolation);
  for (const std::string& skipped : selection.skipped) std::printf("%s\n", skipped.c_str());
  if (selection.kinds.empty()) return EXIT_SUCCESS;
  const std::vector<PlannedFault> plan = MakePlan(selection.kinds, options.faults, options.seed);
  Places places;
  places.work = reaper.folder();
  places.evidence = std::filesystem::path(options.report) / "failed";
  places.own_mounts = isolation.no_mounts.empty();
  places.own_network = isolation.own_network;
  places.helpers = {reaper.pid()};
  std::vector<Outcome> outcomes;
  bool interrupted = false;
  try {
    Suite(places).Run(plan, [&](const Outcome& outcome) {
      outcomes.push_back(outcome);
      Print(outcome, outcomes.size(), plan.size());
    });
  } catch (const Interrupted&) {
    interrupted = true;
  }
  const Report report(outcomes, options.seed, selection.skipped);
  report.Write(options.report);
  std::printf("%s\n", report.Summary().c_str());
  return interrupted ? 130 : report.failed() > 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}

}  // namespace
}  // namespace musher::fault_injection

int main(int argc, char** argv) {
  try {
    const musher::fault_injection::Options options =
        musher::fault_injection::ReadOptions(argc, argv);
    if (options.list) return musher::fault_injection::List();
    return musher::fault_injection::Main(options);
  } catch (const musher::fault_injection::Usage& usage) {
    std::fprintf(stderr, "fault_injection: %s\n", usage.message.c_str());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fault_injection: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
