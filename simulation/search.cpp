#include "musher/simulation/search.hpp"
#include "musher/base/words.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>
#include <thread>

namespace musher::simulation {
namespace {

// How many seeds a thread takes at once.
constexpr std::uint64_t kBatch = 16;
// How many failing scenarios of each invariant are shrunk to find the shortest.
constexpr std::size_t kShrunk = 5;

std::optional<Invariant> ViolatedBy(const MachineConfig& config, const ScenarioOptions& options,
                                    const ScenarioId& id) {
  const auto injections = InjectionsOf(config, id);
  if (!injections) return std::nullopt;
  const ScenarioEnd ending = RunScenario(config, id.seed, injections.value(), options);
  return ending.violation ? std::optional(ending.violation->invariant) : std::nullopt;
}

}  // namespace

Result<Injections> InjectionsOf(const MachineConfig& config, const ScenarioId& id) {
  const Injections all = SampleInjections(config, id.seed, id.bridges);
  if (!id.only) return all;
  Injections some;
  for (const std::size_t number : *id.only) {
    if (number == 0 || number > all.size()) {
      return Error{kCodeParametersInvalid, "seed " + std::to_string(id.seed) + " has " +
                                               Counted(all.size(), "injected event") + ", and no " +
                                               std::to_string(number)};
    }
    some.push_back(all[number - 1]);
  }
  return some;
}

bool Summary::good() const {
  return std::all_of(bad.begin(), bad.end(), [](const auto& seeds) { return seeds.empty(); });
}

void Summary::Add(std::uint64_t seed, const ScenarioEnd& ending) {
  ++scenarios;
  coverage.Add(ending.coverage);
  for (std::size_t i = 0; i < switches.size(); ++i) switches[i] += ending.switches[i];
  checks += ending.checks;
  steps += ending.steps;
  simulated += ending.simulated;
  rule_coverage += ending.rule_coverage;
  if (ending.rested) rests.push_back(*ending.rested);
  if (ending.violation) {
    bad[static_cast<std::size_t>(ending.violation->invariant)].push_back(seed);
  }
}

void Summary::Sort() {
  std::sort(rests.begin(), rests.end());
  for (auto& seeds : bad) std::sort(seeds.begin(), seeds.end());
}

Summary RunMany(const MachineConfig& config, const ScenarioOptions& options, std::uint64_t first,
                std::uint64_t count, unsigned threads,
                const std::function<bool(std::uint64_t)>& on_done) {
  Summary summary;
  std::mutex mutex;  // guards the summary and on_done
  std::atomic<std::uint64_t> next = 0;
  std::atomic<bool> stop = false;
  const auto work = [&] {
    for (;;) {
      const std::uint64_t begin = next.fetch_add(kBatch);
      if (begin >= count || stop) return;
      for (std::uint64_t i = begin; i < std::min(begin + kBatch, count); ++i) {
        const std::uint64_t seed = first + i;
        const ScenarioEnd ending =
            RunScenario(config, seed, SampleInjections(config, seed, options.bridges), options);
        const std::lock_guard lock(mutex);
        summary.Add(seed, ending);
      }
      const std::lock_guard lock(mutex);
      if (on_done && !on_done(summary.scenarios)) stop = true;
    }
  };
  std::vector<std::jthread> others;
  for (unsigned i = 1; i < threads; ++i) others.emplace_back(work);
  work();
  others.clear();  // waits for them
  summary.Sort();
  return summary;
}

// Delta debugging: removes large parts first, then single events.
std::vector<std::size_t> ShrinkWhile(
    std::size_t count, const std::function<bool(const std::vector<std::size_t>&)>& bad) {
  std::vector<std::size_t> only(count);
  std::iota(only.begin(), only.end(), std::size_t{1});
  for (std::size_t part = (count + 1) / 2; part > 0; part = part == 1 ? 0 : (part + 1) / 2) {
    bool smaller = true;
    while (smaller) {
      smaller = false;
      for (std::size_t i = 0; i < only.size(); i += part) {
        std::vector<std::size_t> less = only;
        const auto from = less.begin() + static_cast<std::ptrdiff_t>(i);
        const std::size_t size = std::min(part, less.size() - i);
        less.erase(from, from + static_cast<std::ptrdiff_t>(size));
        if (!bad(less)) continue;
        only = less;
        smaller = true;
        break;
      }
    }
  }
  return only;
}

ScenarioId Shrink(const MachineConfig& config, const ScenarioOptions& options, std::uint64_t seed,
                  Invariant invariant) {
  const auto bad = [&](const std::vector<std::size_t>& only) {
    return ViolatedBy(config, options, {seed, only, options.bridges}) == invariant;
  };
  const std::size_t count = SampleInjections(config, seed, options.bridges).size();
  return {seed, ShrinkWhile(count, bad), options.bridges};
}

std::optional<ScenarioId> ShortestFailingScenario(const MachineConfig& config,
                                                  const ScenarioOptions& options,
                                                  const Summary& summary) {
  std::optional<ScenarioId> shortest;
  for (std::size_t invariant = 0; invariant < kInvariants; ++invariant) {
    const auto& seeds = summary.bad[invariant];
    for (std::size_t i = 0; i < std::min(kShrunk, seeds.size()); ++i) {
      const ScenarioId id = Shrink(config, options, seeds[i], static_cast<Invariant>(invariant));
      if (!shortest || id.only->size() < shortest->only->size()) shortest = id;
    }
  }
  return shortest;
}

}  // namespace musher::simulation
