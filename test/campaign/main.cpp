// Hurts a robot of real processes in every way a robot is hurt, and judges what becomes of it:
//
//   campaign --faults 500 --seed 1 --report DIR [--only KIND]... [--list]
//
// Exit codes: 0 all as promised, 1 a judgement failed, 2 usage, 130 interrupted.

#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "musher/test/campaign/campaign.hpp"
#include "musher/test/campaign/host/isolation.hpp"
#include "musher/test/campaign/host/keeper.hpp"
#include "musher/test/campaign/options.hpp"
#include "musher/test/campaign/report/report.hpp"
#include "musher/test/campaign/robot/processes.hpp"

namespace musher::campaign {
namespace {

void Tell(const Outcome& outcome, std::size_t number, std::size_t of) {
  std::printf("%3zu/%zu %-22s %6.2f s  %s\n", number, of, outcome.kind.c_str(),
              outcome.whole_ms / 1000, outcome.drawn.c_str());
  for (const std::string& failure : outcome.failures) {
    std::printf("        FAILED: %s\n", failure.c_str());
  }
  if (!outcome.failures.empty()) {
    std::printf("        again: campaign --only %s --faults 1 --seed %llu\n", outcome.kind.c_str(),
                static_cast<unsigned long long>(outcome.seed));
  }
  std::fflush(stdout);
}

void InterruptBySignal(int) {
  Interrupt();
}

// An end by a signal is an end in order: the report is written, nothing is left behind.
void WatchSignals() {
  struct sigaction action {};
  action.sa_handler = InterruptBySignal;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

int Main(const Options& options) {
  const Isolation isolation = Isolate();
  const Keeper keeper;
  AdoptOrphans();
  WatchSignals();
  const Selection selection = Select(options, isolation);
  for (const std::string& skipped : selection.skipped) std::printf("%s\n", skipped.c_str());
  if (selection.kinds.empty()) return EXIT_SUCCESS;
  const std::vector<PlannedFault> plan = MakePlan(selection.kinds, options.faults, options.seed);
  Places places;
  places.work = keeper.folder();
  places.evidence = std::filesystem::path(options.report) / "failed";
  places.own_mounts = isolation.no_mounts.empty();
  places.own_network = isolation.own_network;
  places.helpers = {keeper.pid()};
  std::vector<Outcome> outcomes;
  bool interrupted = false;
  try {
    Campaign(places).Run(plan, [&](const Outcome& outcome) {
      outcomes.push_back(outcome);
      Tell(outcome, outcomes.size(), plan.size());
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
}  // namespace musher::campaign

int main(int argc, char** argv) {
  try {
    const musher::campaign::Options options = musher::campaign::ReadOptions(argc, argv);
    if (options.list) return musher::campaign::List();
    return musher::campaign::Main(options);
  } catch (const musher::campaign::Usage& usage) {
    std::fprintf(stderr, "campaign: %s\n", usage.message.c_str());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "campaign: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
