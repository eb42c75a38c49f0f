// Rules of the user with a time, in the search: whatever takes time takes none, or all that it has.

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "musher/search/harness.hpp"
#include "musher/search/proof.hpp"
#include "musher/search/rules.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"
#include "musher/test/search/scenarios.hpp"

namespace musher::search::timed_rules_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// b switches down before a.
MachineConfig Pair() {
  MachineConfig config = testing::MachineOf(2);
  testing::ActuatorNamed(config, "b").after = {"a"};
  return config;
}

ProofOptions With(const MachineConfig& config, const std::string& rule, int faults) {
  UserRulesReading read = ReadUserRules(config, "rules.txt", rule);
  EXPECT_THAT(read.diagnostics, IsEmpty());
  ProofOptions options;
  options.timed_rules = std::move(read.rules.timed);
  options.faults = faults;
  options.threads = 2;
  return options;
}

Proof ProofOf(const MachineConfig& config, const std::string& rule, int faults) {
  return Prove(SearchableConfig(config), With(config, rule, faults));
}

std::string Sentences(const Proof& proof) {
  if (!proof.counter_example) return proof.why;
  std::string text;
  for (const PathStep& step : proof.counter_example->steps) {
    for (const std::string& sentence : step.sentences) text += sentence + "\n";
  }
  return text;
}

TEST(RulesWithATime, HoldWhereAllThatTheirSubjectWaitsForMayTakeLess) {
  const Proof proof = ProofOf(Pair(), "within 200 ms of LowPower a in LowPower", 0);
  EXPECT_EQ(proof.end, ProofEnd::kProved) << Sentences(proof);
  ASSERT_EQ(proof.timed_coverage.size(), 1U);
  EXPECT_GT(proof.timed_coverage[0].begun, 1U);
  EXPECT_GT(proof.timed_coverage[0].met, 1U);
}

TEST(RulesWithATime, AreViolatedWhereTwoCallbacksTakeAllTheirTime) {
  const MachineConfig config = Pair();
  const std::string rule = "within 150 ms of LowPower a in LowPower";
  const Proof proof = ProofOf(config, rule, 0);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  const CounterExample& example = *proof.counter_example;
  EXPECT_THAT(example.violations, ElementsAre("your rule: " + rule));
  EXPECT_EQ(example.task.to, kLowPower);
  EXPECT_EQ(example.steps.size(), 4U)
      << "a request, b takes its time, and ends, and a takes its: " << Sentences(proof);
  const auto replayed =
      Replay(SearchableConfig(config), With(config, rule, 0), example.task, example.path);
  ASSERT_TRUE(replayed);
  EXPECT_EQ(replayed.value().violations, example.violations);
}

TEST(RulesWithATime, AreViolatedByAFault) {
  const MachineConfig config = Pair();
  const std::string rule = " of LowPower a in LowPower or exited";
  EXPECT_EQ(ProofOf(config, "within 200 ms" + rule, 0).end, ProofEnd::kProved);
  const Proof proof = ProofOf(config, "within 200 ms" + rule, 1);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_EQ(proof.proved_faults, 0);
  EXPECT_THAT(proof.counter_example->violations,
              Contains(HasSubstr("your rule: within 200 ms" + rule)));
}

// The subject need not get there at all.
TEST(RulesWithATime, AreViolatedWhereTheMachineRestsBefore) {
  const std::string rule = "within 24 min of LowPower a in Error";
  const Proof proof = ProofOf(Pair(), rule, 0);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_THAT(proof.counter_example->violations,
              ElementsAre("your rule: " + rule + " (nothing is left to happen)"));
}

TEST(RulesWithATime, BeginNoTimeWhereTheMachineNeverGoesThere) {
  const Proof proof = ProofOf(testing::MachineOf(1), "within 1 s of SetUp a in Active", 0);
  EXPECT_EQ(proof.end, ProofEnd::kProved) << Sentences(proof);
  EXPECT_EQ(proof.timed_coverage[0].begun, 0U);
}

// Whose own time is not over; it is no fault then.
TEST(RulesWithATime, LetTheDeadlineOfAnotherActuatorPassWhileACallbackRuns) {
  MachineConfig config = testing::Ours(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.on_lost = "Active";
  auto& times = testing::ActuatorNamed(config, "b").times;
  times.assign(times.size(), Milliseconds(5000));
  Model model(config, State(kLowPower));
  model.timed_rules = ReadUserRules(config, "", "within 9 s of LowPower b in LowPower").rules.timed;
  World world = WorldIn(model, State(kActive));
  world.faults = world.faults_left = 1;
  Notes notes;
  const auto make = [&](ChoiceKind kind, std::uint8_t index) {
    const std::vector<Choice> choices = Choices(model, world);
    const auto found = std::ranges::find_if(
        choices, [&](const Choice& one) { return one.kind == kind && one.index == index; });
    ASSERT_NE(found, choices.end());
    EXPECT_EQ(found->cost, kind == ChoiceKind::kCrash ? 1 : 0);
    Make(model, world, Choice(*found), notes);
  };
  make(ChoiceKind::kRequest, 0);
  while (!world.outbox.empty()) make(ChoiceKind::kDeliver, 0);
  make(ChoiceKind::kCrash, 0);
  for (int passed = 0; passed < 10 && world.actuators[0].processes < 2; ++passed) {
    make(ChoiceKind::kTime, 1);
  }
  EXPECT_EQ(world.actuators[0].processes, 2);
  EXPECT_EQ(world.actuators[1].work, Work::kRunning);
  EXPECT_THAT(notes.violations, IsEmpty());
}

// --- random machines: nothing takes longer than what is proved ---

class Sampled {
 public:
  explicit Sampled(unsigned seed) : random_(seed) {
    config_ = testing::MachineOf(2 + Below(2));
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      ActuatorConfig& actuator = config_.actuators[i];
      for (Duration& time : actuator.times) time = Milliseconds(30 + 10 * Below(10));
      for (ActuatorIndex k; k < i; ++k) {
        if (Below(2) == 0) actuator.after.push_back(config_.actuators[k].name);
      }
    }
  }

  int Below(int end) { return std::uniform_int_distribution(0, end - 1)(random_); }
  const MachineConfig& config() const { return config_; }
  static std::string Rule(int ms) {
    return "within " + std::to_string(ms) + " ms of Error a in Error or exited";
  }
  ProofOptions Options(int ms, int faults) const {
    ProofOptions options = With(config_, Rule(ms), faults);
    options.from = State(kActive);
    return options;
  }
  bool IsProved(int ms, int faults) const {
    return Prove(config_, Options(ms, faults)).end == ProofEnd::kProved;
  }

  // The least time that is proved.
  int LeastProved(int faults) const {
    int violated = 0;
    int proved = 4000;
    EXPECT_TRUE(IsProved(proved, faults));
    while (proved - violated > 1) {
      const int middle = (violated + proved) / 2;
      (IsProved(middle, faults) ? proved : violated) = middle;
    }
    return proved;
  }

  // What takes time takes any; returns what it violates.
  std::vector<std::string> Walk(int ms) {
    Model model(config_, State(kError));
    model.timed_rules = Options(ms, 0).timed_rules;
    World world = WorldIn(model, State(kActive));
    Notes notes;
    for (int made = 0; made < 1000 && notes.violations.empty(); ++made) {
      const std::vector<Choice> choices = Choices(model, world);
      if (IsQuiet(world, choices)) break;
      const Choice choice = choices[static_cast<std::size_t>(Below(int(choices.size())))];
      if (choice.kind != ChoiceKind::kWait) {
        Make(model, world, choice, notes);
        continue;
      }
      const std::int64_t most = (*EndOfWait(model, world) - world.now).count();
      world.now += Duration(std::uniform_int_distribution<std::int64_t>(1, most)(random_));
      UpdateTimedRules(model, world, notes);
    }
    return notes.violations;
  }

 private:
  std::mt19937 random_;
  MachineConfig config_;
};

TEST(RulesWithATime, AreMetInTheTimeThatIsProvedAlsoByCallbacksThatTakeSomeOfTheirs) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Sampled sampled(seed);
    const int least = sampled.LeastProved(0);
    EXPECT_GE(least, 30) << seed;
    for (int walk = 0; walk < 200; ++walk) {
      EXPECT_THAT(sampled.Walk(least), IsEmpty()) << seed;
    }
  }
}

}  // namespace musher::search::timed_rules_test
