// What is left out of a search loses no stable state and no violation: against the plain search, on
// random machines.

#include "musher/search/reduction.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <deque>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/search/fingerprint.hpp"
#include "musher/search/proof.hpp"
#include "musher/search/rules.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"
#include "musher/test/search/scenarios.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::search::reduction_test {

// A machine of two or three actuators in stages, with an order, bindings, restarts and fallbacks.
class RandomMachine {
 public:
  explicit RandomMachine(unsigned seed) : random_(seed) {
    const int count = seed % 3 == 0 ? 3 : 2;
    config_ = Below(3) == 0 ? testing::MachineOf(count) : testing::Ours(count);
    int stage = 1;
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      ActuatorConfig& actuator = config_.actuators[i];
      stage = std::min(2, stage + (Below(4) == 0 && i.value() > 0 ? 1 : 0));
      actuator.stage = stage;
      actuator.critical = Below(3) == 0;
      actuator.on_lost = State(actuator.critical ? kProtected
                               : Below(3) == 0   ? kDeActive
                                                 : kActive);
      actuator.restart.limit = Below(3);
      for (Duration& time : actuator.times) time = Milliseconds(100 + 50 * Below(3));
      for (ActuatorIndex k; k < i; ++k) {
        if (Below(3) == 0) actuator.after.push_back(config_.actuators[k].name);
        if (Below(6) == 0) actuator.binds_to.push_back(config_.actuators[k].name);
      }
    }
    const std::vector<State> states = {kActive,   kProtected, kDeActive,
                                       kLowPower, kSelfCheck, kError};
    from_ = states[static_cast<std::size_t>(Below(static_cast<int>(states.size())))];
  }

  Proof Prove(bool reduces) const {
    ProofOptions options;
    options.from = from_;
    options.threads = 2;
    options.reduces = reduces;
    options.stable_rules =
        ReadUserRules(config_, "", "never a OTA while machine is Error").rules.stable;
    return search::Prove(SearchableConfig(config_), options);
  }

  const MachineConfig& config() const { return config_; }

 private:
  int Below(int end) { return std::uniform_int_distribution(0, end - 1)(random_); }

  std::mt19937 random_;
  MachineConfig config_;
  State from_;
};

std::string Violations(const Proof& proof) {
  if (!proof.counter_example) return {};
  return ::testing::PrintToString(proof.counter_example->violations);
}

// How many stable states each of its searches has reached.
std::map<std::string, std::size_t> StableStates(const Proof& proof) {
  std::map<std::string, std::size_t> counts;
  for (const ProvedTask& task : proof.tasks) {
    counts[task.task.Text() + ", " + std::to_string(task.task.faults)] = task.figures.leaves;
  }
  return counts;
}

// With 18 and 21 a first reduction lost stable states.
std::vector<unsigned> Seeds() {
  std::vector<unsigned> seeds = {5, 18, 21, 26};
  for (unsigned seed = 1; musher::testing::Nightly() && seed <= 60; ++seed) seeds.push_back(seed);
  return seeds;
}

// What counts in a stable state is the same in both searches. They are some of those of the plain
// search: as many are the same ones.
TEST(Reduction, LosesNoStableStateAndNoViolation) {
  std::size_t plain_nodes = 0;
  std::size_t reduced_nodes = 0;
  for (const unsigned seed : Seeds()) {
    const RandomMachine machine(seed);
    const Proof plain = machine.Prove(false);
    const Proof reduced = machine.Prove(true);
    ASSERT_EQ(reduced.end, plain.end) << seed << Violations(plain) << Violations(reduced);
    EXPECT_EQ(Violations(reduced), Violations(plain)) << seed;
    EXPECT_EQ(reduced.proved_faults, plain.proved_faults) << seed;
    if (plain.counter_example) continue;
    EXPECT_EQ(StableStates(reduced), StableStates(plain)) << seed;
    EXPECT_EQ(reduced.rule_coverage[0].states, plain.rule_coverage[0].states) << seed;
    plain_nodes += plain.figures.nodes;
    reduced_nodes += reduced.figures.nodes;
  }
  EXPECT_LT(reduced_nodes, plain_nodes);
}

// One search with one fault.
Figures FiguresOf(const MachineConfig& config, const State& to, bool reduces) {
  Model model(SearchableConfig(config), to);
  for (const ActuatorIndex i : model.kinds.Indices()) model.kinds[i] = i;  // no symmetry
  model.reduces = reduces;
  World root = WorldIn(model, State(kActive));
  root.faults = root.faults_left = 1;
  SearchLimits limits;
  const Searched searched = SearchDepthFirst(model, root, limits);
  EXPECT_FALSE(searched.fault);
  return searched.figures;
}

// With starts that finish it, and starts by a person, which may find it.
TEST(Reduction, OfATearDownLosesNoStableState) {
  MachineConfig config = testing::Ours(3);
  for (ActuatorConfig& actuator : config.actuators) actuator.on_lost = "Active";
  testing::ActuatorNamed(config, "c").after = {"a"};
  const Figures plain = FiguresOf(config, State(kTearDown), false);
  const Figures reduced = FiguresOf(config, State(kTearDown), true);
  EXPECT_EQ(reduced.leaves, plain.leaves);
  EXPECT_LT(reduced.nodes, plain.nodes);
}

// All that can be violated on the way to `to` with one fault, not only the first.
std::set<std::string> ReachableViolations(const MachineConfig& config, const Rules& rules,
                                          const State& to, bool reduces) {
  const Model correct(SearchableConfig(config), to);
  Model model(correct.config, to, rules);
  for (const ActuatorIndex i : model.kinds.Indices()) model.kinds[i] = i;  // no symmetry
  model.reduces = reduces;
  World root = WorldIn(correct, State(kActive));
  root.faults = root.faults_left = 1;
  std::set<std::string> violations;
  std::set<Fingerprint> seen = {IdentityOf(model, root).fingerprint};
  std::deque<World> left = {root};
  for (; !left.empty(); left.pop_front()) {
    const World& world = left.front();
    const std::vector<Choice> choices = Choices(model, world);
    const auto only = SearchedAlone(model, world);
    Notes notes;
    if (IsQuiet(world, choices)) CheckRest(model, world, notes);
    for (const Choice& choice : choices) {
      if (only && choice.which() != *only) continue;
      World next = world;
      Make(model, next, choice, notes);
      if (seen.insert(IdentityOf(model, next).fingerprint).second) left.push_back(std::move(next));
    }
    violations.insert(notes.violations.begin(), notes.violations.end());
  }
  return violations;
}

// Changes the machine before each step of the controller.
template <typename Change>
Rules WithMachine(Change change) {
  Rules rules;
  rules.controller = [change](const auto& config, Machine& machine, const Event& event, Time now) {
    for (KnownActuator& known : machine.actuators) {
      const bool exited =
          known.report.incarnation != 0 && known.report.incarnation == known.process.dead;
      if (exited) change(machine, known);
    }
    return Step(config, machine, event, now);
  };
  return rules;
}

// Flaws that count only once a process has exited.
const std::map<std::string, Rules>& FlawsAfterAnExit() {
  static const std::map<std::string, Rules> flaws = {
      {"its exit is forgotten",
       WithMachine([](Machine&, KnownActuator& known) { known.presence = Presence::kPresent; })},
      {"its fault is forgotten",
       WithMachine([](Machine&, KnownActuator& known) { known.fault.reset(); })},
      {"that a TearDown is finished is forgotten",
       WithMachine([](Machine& machine, KnownActuator&) { machine.start_up.finishing = false; })},
      {"its state is taken for that of the machine",
       WithMachine([](Machine& machine, KnownActuator& known) {
         if (machine.phase == Phase::kRunning && !machine.current) machine.state = known.state();
       })},
  };
  return flaws;
}

std::vector<unsigned> SeedsOfFlaws() {
  std::vector<unsigned> seeds = {5};
  for (unsigned seed = 1; musher::testing::Nightly() && seed <= 20; ++seed) seeds.push_back(seed);
  return seeds;
}

TEST(Reduction, LosesNoViolationOfAFlawThatCountsAfterAnExit) {
  for (const auto& [what, rules] : FlawsAfterAnExit()) {
    std::size_t found = 0;
    for (const unsigned seed : SeedsOfFlaws()) {
      for (const char* to : {"TearDown", "LowPower"}) {
        const MachineConfig config = RandomMachine(seed).config();
        const auto plain = ReachableViolations(config, rules, State(to), false);
        EXPECT_EQ(ReachableViolations(config, rules, State(to), true), plain) << what << seed << to;
        found += plain.size();
      }
    }
    EXPECT_GT(found, 0U) << what;
  }
}

}  // namespace musher::search::reduction_test
