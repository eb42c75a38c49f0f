// Robots of several hosts, with the injected events of their seeds: reboots, hard and in order, and
// cut links among them. Every invariant of one host holds over them.
//
//   OfUnits     the systemds of the hosts run actuators as units (simulation/simulated_systemds.hpp)
//   OfStandbys  a standby leads the machine once its controller is gone (controller/standby.hpp)
//
//   MUSHER_SEED=42 simulation_test --gtest_filter='OfUnits*/0'
//     runs one scenario, and prints its timeline
//   MUSHER_SEEDS=100000 [MUSHER_FIRST=1] …
//     runs that many

#include <gmock/gmock.h>

#include <cstdlib>
#include <iostream>
#include <string>
#include <tuple>

#include "musher/simulation/search.hpp"
#include "musher/simulation/timeline.hpp"
#include "musher/test/simulation/sampled_config.hpp"

namespace musher::testing::hosts_test {

using simulation::Scenario;
using simulation::ScenarioEnd;
using simulation::ScenarioOptions;
using simulation::Timeline;

std::uint64_t Environment(const char* name, std::uint64_t otherwise) {
  const char* value = std::getenv(name);
  return value == nullptr ? otherwise : std::strtoull(value, nullptr, 10);
}

ScenarioOptions OptionsFor(const MachineConfig& config) {
  ScenarioOptions options = simulation::UsualOptions(config);
  options.provided = false;  // a sampled robot may run without any of its actuators
  options.shared_processes = true;
  return options;
}

using Sample = MachineConfig (*)(std::uint64_t seed);

std::string TimelineOf(Sample sample, std::uint64_t seed) {
  const MachineConfig config = sample(seed);
  Scenario scenario(config, seed, simulation::SampleInjections(config, seed), OptionsFor(config));
  Timeline timeline(scenario, config);
  timeline.End(scenario.Run());
  return timeline.Text();
}

constexpr std::uint64_t kParts = 4;

class SeveralHosts : public ::testing::TestWithParam<std::tuple<Sample, std::uint64_t>> {};

TEST_P(SeveralHosts, HoldTheInvariants) {
  const auto& [sample, part] = GetParam();
  if (const std::uint64_t seed = Environment("MUSHER_SEED", 0); seed != 0) {
    if (part != 0) GTEST_SKIP();
    const std::string run = TimelineOf(sample, seed);
    std::cout << run;
    EXPECT_EQ(run.find("✗"), std::string::npos) << "it still fails";
    return;
  }
  constexpr std::uint64_t kInTheGate = 200;
  const std::uint64_t seeds = Environment("MUSHER_SEEDS", kInTheGate);
  const std::uint64_t first = Environment("MUSHER_FIRST", 1);
  for (std::uint64_t seed = first + part; seed < first + seeds; seed += kParts) {
    const MachineConfig config = sample(seed);
    const ScenarioEnd ending =
        RunScenario(config, seed, simulation::SampleInjections(config, seed), OptionsFor(config));
    if (ending.violation) ADD_FAILURE() << "seed " << seed << ": " << ending.violation->what;
  }
}

INSTANTIATE_TEST_SUITE_P(OfUnits, SeveralHosts,
                         ::testing::Combine(::testing::Values(&SampleConfigWithUnits),
                                            ::testing::Range(std::uint64_t{0}, kParts)));
INSTANTIATE_TEST_SUITE_P(OfStandbys, SeveralHosts,
                         ::testing::Combine(::testing::Values(&SampleConfigWithStandby),
                                            ::testing::Range(std::uint64_t{0}, kParts)));

}  // namespace musher::testing::hosts_test
