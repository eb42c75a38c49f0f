// The proof of a config: of small machines that hold every rule, and of some that do not.

#include "musher/search/proof.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <new>

#include "musher/base/joined.hpp"
#include "musher/search/fingerprint_set.hpp"
#include "musher/search/rules.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"
#include "musher/test/search/scenarios.hpp"

namespace musher::search::proof_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Proof ProofOf(const MachineConfig& config, int faults, const ProofOptions& more = {}) {
  ProofOptions options = more;
  options.faults = faults;
  options.threads = 2;
  return Prove(SearchableConfig(config), options);
}

std::string Sentences(const Proof& proof) {
  std::string text;
  if (!proof.counter_example) return proof.why;
  for (const PathStep& step : proof.counter_example->steps) {
    for (const std::string& sentence : step.sentences) text += sentence + "\n";
  }
  for (const std::string& violation : proof.counter_example->violations) {
    text += "VIOLATION: " + violation + "\n";
  }
  return text;
}

// The machine and its actuators without a state.
void Remove(MachineConfig& config, const State& state) {
  std::erase(config.states, state);
  for (ActuatorConfig& actuator : config.actuators) {
    const auto place = std::ranges::find(actuator.states, state);
    actuator.times.erase(actuator.times.begin() + (place - actuator.states.begin()));
    actuator.states.erase(place);
  }
  std::erase_if(config.flow,
                [&](const FlowEdge& edge) { return edge.from == state || edge.to == state; });
}

// Two actuators that are alike, and a third that waits for both.
MachineConfig WithLast() {
  MachineConfig config = testing::MachineOf(3);
  testing::ActuatorNamed(config, "c").after = {"a", "b"};
  return config;
}

// An actuator that does not undergo the crash of its process.
Rules WithoutCrashes() {
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    Event changed = event;
    if (auto* ended = std::get_if<event::ProcessEnded>(&changed)) ended->pid = 0;
    return Step(config, machine, changed, now);
  };
  return rules;
}

TEST(ProofOfAConfig, HoldsForTwoActuatorsAndOneFault) {
  const Proof proof = ProofOf(testing::MachineOf(2), 1);
  EXPECT_EQ(proof.end, ProofEnd::kProved) << Sentences(proof);
  EXPECT_EQ(proof.proved_faults, 1);
  EXPECT_THAT(proof.not_reached, IsEmpty());
  EXPECT_GT(proof.figures.nodes, 1000U);
}

TEST(ProofOfAConfig, HoldsForAStartInStagesWithRestarts) {
  MachineConfig config = testing::Ours(2);
  testing::ActuatorNamed(config, "a").on_lost = "Active";
  testing::ActuatorNamed(config, "b").on_lost = "Active";
  testing::ActuatorNamed(config, "b").stage = 2;
  const Proof proof = ProofOf(config, 1);
  EXPECT_EQ(proof.end, ProofEnd::kProved) << Sentences(proof);
}

TEST(ProofOfAConfig, SearchesOnlyWhatBeginsInTheStateThatIsNamed) {
  ProofOptions options;
  options.from = State(kLowPower);
  const Proof proof = ProofOf(testing::MachineOf(2), 0, options);
  EXPECT_EQ(proof.end, ProofEnd::kProved);
  ASSERT_FALSE(proof.tasks.empty());
  for (const ProvedTask& task : proof.tasks) EXPECT_EQ(task.task.from, kLowPower);
}

// No transition leads to OTA.
TEST(ProofOfAConfig, IsNotFinishedFromAStateThatNothingLeadsTo) {
  MachineConfig config = testing::MachineOf(2);
  std::erase_if(config.flow, [](const FlowEdge& edge) { return edge.to == kOta; });
  ProofOptions options;
  options.from = State(kOta);
  const Proof proof = ProofOf(config, 0, options);
  EXPECT_EQ(proof.end, ProofEnd::kNotFinished);
  EXPECT_EQ(proof.why, "no sequence of requests without a fault leads to OTA");
  EXPECT_EQ(proof.proved_faults, -1);
  EXPECT_THAT(proof.not_reached, ElementsAre(kOta));
}

// A machine without Error is in SelfCheck only where a program drives its start.
TEST(ProofOfAConfig, FollowsTheSelfCheckOfAStartByHand) {
  MachineConfig config = testing::MachineOf(2);
  Remove(config, kError);
  const Proof proof = ProofOf(config, 0);
  EXPECT_EQ(proof.end, ProofEnd::kProved) << Sentences(proof);
  EXPECT_THAT(proof.not_reached, IsEmpty());
  EXPECT_THAT(proof.tasks, Contains(Field(&ProvedTask::task, ProofTask{kSelfCheck, kActive, 0})));
}

// The planted fault is in what follows a failure that the config does not list.
TEST(ProofOfAConfig, SearchesAFailureOfASelfCheckThatIsTolerated) {
  MachineConfig config = testing::MachineOf(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.critical_codes = {3009};
  ProofOptions options;
  options.from = State(kSelfCheck);
  EXPECT_EQ(ProofOf(config, 1, options).end, ProofEnd::kProved);
  options.rules.controller = [](const auto& of, auto& machine, const Event& event, Time now) {
    const auto* replied = std::get_if<event::Replied>(&event);
    const bool checks = machine.current && machine.current->target == kSelfCheck;
    const bool fails = checks && replied != nullptr && replied->report.outcome_code != kCodeOk;
    if (fails && replied->report.outcome_code != 3009) machine.phase = Phase::kFenced;
    return Step(of, machine, event, now);
  };
  options.from = State(kSetUp);
  const Proof proof = ProofOf(config, 1, options);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_THAT(Sentences(proof), HasSubstr("fails, with a code that is not critical"));
}

// The controller queries an actuator again and again, whatever it answers.
TEST(ProofOfAConfig, FindsAMachineThatNeverComesToRest) {
  ProofOptions options;
  options.from = State(kActive);
  options.rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    auto actions = Step(config, machine, event, now);
    KnownActuator& first = machine.actuators[0];
    const bool queries = machine.state == kDeActive && first.presence == Presence::kPresent;
    if (queries) first.control.again = now + Milliseconds(100);
    return actions;
  };
  const Proof proof = ProofOf(testing::MachineOf(2), 0, options);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_TRUE(proof.counter_example->repeats);
  EXPECT_EQ(proof.counter_example->task, (ProofTask{kActive, kDeActive, 0}));
  EXPECT_THAT(proof.counter_example->violations,
              ElementsAre(HasSubstr("the machine never comes to rest: the last ")));
  const auto replayed = Replay(SearchableConfig(testing::MachineOf(2)), options,
                               proof.counter_example->task, proof.counter_example->path);
  ASSERT_TRUE(replayed);
  EXPECT_TRUE(replayed.value().repeats);
  EXPECT_THAT(replayed.value().violations,
              ElementsAre(HasSubstr("the machine is where it was before: the last ")));
}

TEST(ProofOfAConfig, ReplaysACounterExample) {
  ProofOptions options;
  options.rules = WithoutCrashes();
  const MachineConfig config = SearchableConfig(testing::MachineOf(2));
  const Proof proof = ProofOf(config, 1, options);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  const CounterExample& found = *proof.counter_example;
  const auto replayed = Replay(config, options, found.task, found.path);
  ASSERT_TRUE(replayed);
  EXPECT_EQ(replayed.value().violations, found.violations);
  EXPECT_EQ(replayed.value().choices, found.choices);
  const auto without = Replay(config, {}, found.task, found.path);
  ASSERT_TRUE(without) << "the planted fault changes no number before it";
  EXPECT_THAT(without.value().violations, IsEmpty());
}

TEST(ProofOfAConfig, FindsAPlantedFaultWithTheFewestFaultsAndChoices) {
  ProofOptions options;
  options.rules = WithoutCrashes();
  const Proof proof = ProofOf(testing::MachineOf(2), 2, options);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_EQ(proof.proved_faults, 0);
  EXPECT_EQ(proof.counter_example->task.faults, 1);
  EXPECT_EQ(proof.counter_example->steps.size(), 2U) << Sentences(proof);
  EXPECT_THAT(proof.counter_example->violations, Contains(HasSubstr("has exited in")));
}

// An actuator that obeys any participant that names a higher epoch.
TEST(ProofOfAConfig, SearchesTheMessagesOfAnotherMachineWhereTheyAreFaults) {
  ProofOptions options;
  options.from = State(kLowPower);
  const Proof without = ProofOf(testing::MachineOf(2), 1, options);
  options.other_machine = true;
  const Proof with = ProofOf(testing::MachineOf(2), 1, options);
  EXPECT_EQ(with.end, ProofEnd::kProved) << Sentences(with);
  EXPECT_GT(with.figures.transitions, without.figures.transitions);
  options.rules.actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event,
                              Time now) {
    if (const auto* arrived = std::get_if<actuator_event::SwitchArrived>(&event)) {
      const actuator_event::ControllerHeartbeatReceived announced{arrived->sender,
                                                                  arrived->command.epoch};
      Step(config, i, core, announced, now);
    }
    return Step(config, i, core, event, now);
  };
  const Proof planted = ProofOf(testing::MachineOf(2), 1, options);
  ASSERT_EQ(planted.end, ProofEnd::kViolated);
  EXPECT_THAT(planted.counter_example->violations,
              Contains(HasSubstr("message of another machine")));
}

TEST(ProofOfAConfig, EndsWhereItsCallerDoes) {
  ProofOptions options;
  options.on_progress = [](const ProofProgress& progress) {
    return progress.faults == 1 ? "the test has seen enough" : "";
  };
  const Proof proof = ProofOf(testing::MachineOf(3), 2, options);
  EXPECT_EQ(proof.end, ProofEnd::kNotFinished);
  EXPECT_EQ(proof.why, "the test has seen enough");
  EXPECT_EQ(proof.proved_faults, 0);
}

TEST(ProofOfAConfig, EndsWhileItFindsTheStates) {
  ProofOptions options;
  options.on_progress = [](const ProofProgress&) { return "the test has seen enough"; };
  const Proof proof = ProofOf(testing::MachineOf(3), 2, options);
  EXPECT_EQ(proof.end, ProofEnd::kNotFinished);
  EXPECT_EQ(proof.why, "the test has seen enough");
  EXPECT_TRUE(proof.tasks.empty());
}

// b has done its part of the switch up, crashes and is restarted, all before the switch ends.
TEST(ProofOfAConfig, AllowsASwitchUpThatAnActuatorIsLostAfter) {
  MachineConfig config = testing::Ours(2);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.times.assign(actuator.times.size(), Milliseconds(1000));  // beyond the restart
  }
  const Model model(config, kActive);
  World world = NewWorld(model);
  Notes notes;
  Begin(model, world, false, notes);
  RunUntilStable(model, world, notes);
  RequestSwitch(model, world, kProtected, notes);
  RunUntilStable(model, world, notes);
  world.requests.clear();
  world.from = kProtected;
  world.at_start = true;
  world.faults = world.faults_left = 2;
  notes.log = true;
  const std::vector<std::pair<ChoiceKind, std::uint8_t>> scenario = {
      {ChoiceKind::kRequest, 0}, {ChoiceKind::kDeliver, 0}, {ChoiceKind::kDeliver, 1},
      {ChoiceKind::kStatus, 0},  {ChoiceKind::kEndOk, 1},   {ChoiceKind::kCrash, 1},
      {ChoiceKind::kTime, 0},    {ChoiceKind::kEndOk, 0}};
  for (const auto& [kind, actuator] : scenario) {
    const std::vector<Choice> choices = Choices(model, world);
    const auto next = std::ranges::find_if(choices, [&](const Choice& choice) {
      return choice.kind == kind && choice.actuator == actuator;
    });
    ASSERT_NE(next, choices.end()) << static_cast<int>(kind);
    Make(model, world, *next, notes);
  }
  EXPECT_EQ(world.requests.front().replies, 1) << Joined(notes.scenario);
  EXPECT_THAT(notes.violations, IsEmpty());
}

TEST(ProofOfAConfig, IsNotFinishedWithoutMemory) {
  ProofOptions options;
  std::atomic<int> steps = 0;
  options.rules.controller = [&](const auto& config, auto& machine, const Event& event, Time now) {
    if (++steps == 5000) throw std::bad_alloc();
    return Step(config, machine, event, now);
  };
  const Proof proof = ProofOf(testing::MachineOf(2), 1, options);
  EXPECT_EQ(proof.end, ProofEnd::kNotFinished);
  EXPECT_EQ(proof.why, "there is no more memory");
}

// `lamp` does not list the state to which the machine falls back when `legs` is lost.
TEST(ProofOfAConfig, FindsAFallbackThatAnActuatorDoesNotList) {
  MachineConfig config = testing::MachineOf(2);
  ActuatorConfig& legs = testing::ActuatorNamed(config, "a");
  legs.critical = true;
  legs.on_lost = "Protected";
  ActuatorConfig& lamp = testing::ActuatorNamed(config, "b");
  std::erase(lamp.states, State("Protected"));
  lamp.times.pop_back();
  const Proof proof = ProofOf(config, 1);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_EQ(proof.counter_example->task.faults, 1);
  EXPECT_THAT(proof.counter_example->violations,
              Contains(HasSubstr("Protected is not among the states of b")));
}

// b of the second stage waits for a, which is suspended until c of the same stage is up: b counts
// as blocked meanwhile, and because it is critical, the machine falls back in the middle of its
// start.
TEST(ProofOfAConfig, FindsABindingThatBlocksAStage) {
  MachineConfig config = testing::Ours(3);
  for (ActuatorConfig& actuator : config.actuators) actuator.on_lost = "Active";
  ActuatorConfig& last = testing::ActuatorNamed(config, "b");
  last.stage = 2;
  last.after = {"a"};
  last.critical = true;
  last.on_lost = "Protected";
  testing::ActuatorNamed(config, "c").stage = 2;
  testing::ActuatorNamed(config, "a").binds_to = {"c"};
  const Proof proof = ProofOf(config, 1);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_EQ(proof.counter_example->task.faults, 0);
  EXPECT_TRUE(proof.counter_example->task.IsStart());
  EXPECT_THAT(proof.counter_example->violations,
              Contains(HasSubstr("the start has left the machine in Protected")));
}

TEST(ProofOfAConfig, FindsAnActuatorThatIsLostWithoutOnLost) {
  MachineConfig config = testing::Ours(2);
  testing::ActuatorNamed(config, "a").on_lost = "Active";
  testing::ActuatorNamed(config, "b").restart.policy = RestartPolicy::kNo;
  const Proof proof = ProofOf(config, 1);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_THAT(proof.counter_example->violations, Contains(HasSubstr("b has no on_lost")));
}

// Makes the first choice of this kind, with this index.
void MakeOne(const Model& model, World& world, ChoiceKind kind, Notes& notes, int index = 0) {
  const std::vector<Choice> choices = Choices(model, world);
  const auto next = std::ranges::find_if(
      choices, [&](const Choice& choice) { return choice.kind == kind && choice.index == index; });
  ASSERT_NE(next, choices.end()) << static_cast<int>(kind);
  Make(model, world, *next, notes);
}

// --- other hosts ---

TEST(OtherHosts, AreCutOffAndBootAgainAsOneFault) {
  const Proof proof = ProofOf(TwoHosts().config, 1);
  EXPECT_EQ(proof.end, ProofEnd::kProved) << Sentences(proof);
  EXPECT_THAT(LeftOutOf(TwoHosts().config),
              ElementsAre("[transport]: actuators without `host` run on the controller's"));
  MachineConfig on_one = TwoHosts().config;
  on_one.actuators[1].host.clear();
  EXPECT_GT(proof.figures.nodes, ProofOf(on_one, 1).figures.nodes);
}

// The robot may go on without b, which its config does not say.
TEST(OtherHosts, NeedAnOnLostOfTheirActuators) {
  MachineConfig config = TwoHosts().config;
  config.actuators[1].critical = false;
  config.actuators[1].on_lost = {};
  const Proof proof = ProofOf(config, 1);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_THAT(Sentences(proof), HasSubstr("host board is out of reach"));
  EXPECT_THAT(proof.counter_example->violations, Contains(HasSubstr("b has no on_lost")));
  config.actuators[1].on_lost = "Active";
  EXPECT_EQ(ProofOf(config, 1).end, ProofEnd::kProved);
}

// A machine of two hosts in Active, after a fault that the controller has noticed.
class AfterTheLossOfAHost : public ::testing::Test {
 protected:
  void Lose(ChoiceKind fault) {
    world_.faults = world_.faults_left = 1;
    for (const ChoiceKind kind : {ChoiceKind::kRequest, fault, ChoiceKind::kSilence}) {
      MakeOne(model_, world_, kind, notes_);
    }
    EXPECT_FALSE(world_.machine.actuators[1].presence == Presence::kPresent);
  }
  void ExpectBothInProtected() {
    EXPECT_TRUE(RunUntilStable(model_, world_, notes_));
    EXPECT_THAT(notes_.violations, IsEmpty());
    EXPECT_EQ(world_.machine.state, kProtected);
    for (const SimActuator& actuator : world_.actuators) {
      EXPECT_TRUE(actuator.alive);
      EXPECT_EQ(actuator.core.report.state, kProtected);
    }
  }

  const Model model_{TwoHosts().config, State(kActive)};
  World world_ = WorldIn(model_, State(kActive));
  Notes notes_;
};

TEST_F(AfterTheLossOfAHost, TheSameProcessIsUsedOnceItIsReachedAgain) {
  Lose(ChoiceKind::kCutLink);
  ExpectBothInProtected();
  EXPECT_EQ(world_.actuators[1].processes, 1);
}

TEST_F(AfterTheLossOfAHost, ANewProcessIsStartedOnceItHasBootedAgain) {
  Lose(ChoiceKind::kRebootHost);
  ExpectBothInProtected();
  EXPECT_EQ(world_.actuators[1].processes, 2);
  EXPECT_EQ(world_.actuators[1].core.report.host, "board/1");
}

// --- a hang ---

// a is restarted; b, which nothing starts, is not.
TEST(Hang, OfAnActuatorWithACheckpointIsAFault) {
  MachineConfig config = testing::Ours(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.on_lost = "Active";
  config.actuators[1].command.clear();
  const Proof without = ProofOf(config, 1);
  for (ActuatorConfig& actuator : config.actuators) actuator.checkpoint = Milliseconds(500);
  const Proof proof = ProofOf(config, 1);
  EXPECT_EQ(proof.end, ProofEnd::kProved) << Sentences(proof);
  EXPECT_GT(proof.figures.nodes, without.figures.nodes);
}

TEST(Hang, EndsWithAnotherProcess) {
  MachineConfig config = testing::Ours(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.on_lost = "Active";
  config.actuators[0].checkpoint = Milliseconds(500);
  const Model model(config, State(kActive));
  World world = WorldIn(model, State(kActive));
  world.faults = world.faults_left = 1;
  Notes notes;
  for (const ChoiceKind kind : {ChoiceKind::kRequest, ChoiceKind::kHang}) {
    MakeOne(model, world, kind, notes);
  }
  EXPECT_TRUE(world.actuators[0].hung);
  EXPECT_TRUE(RunUntilStable(model, world, notes));
  EXPECT_THAT(notes.violations, IsEmpty());
  EXPECT_EQ(world.actuators[0].processes, 2);
  EXPECT_EQ(world.actuators[0].core.report.state, kActive);
}

// --- the battery ---

TEST(Battery, FallsToEachOfTheLevelsOfTheConfigAsOneFault) {
  MachineConfig config = testing::MachineOf(2);
  const Proof without = ProofOf(config, 1);
  config.policy.emplace().battery.emplace().protected_at = 31;
  const Proof proof = ProofOf(config, 1);
  EXPECT_EQ(proof.end, ProofEnd::kProved) << Sentences(proof);
  EXPECT_GT(proof.figures.nodes, without.figures.nodes);
  EXPECT_THAT(BatteryLevels(SearchableConfig(config)), ElementsAre(31, 5, 0));
}

// The battery is empty once three samples have reported it.
TEST(Battery, ThatIsEmptyTearsTheMachineDown) {
  MachineConfig config = testing::MachineOf(2);
  config.policy.emplace().battery.emplace();
  const Model model(config, State(kActive));
  World world = WorldIn(model, State(kActive));
  world.faults = world.faults_left = 1;
  Notes notes;
  MakeOne(model, world, ChoiceKind::kRequest, notes);
  MakeOne(model, world, ChoiceKind::kBatteryFalls, notes, 2);
  EXPECT_TRUE(RunUntilStable(model, world, notes));
  EXPECT_THAT(notes.violations, IsEmpty());
  EXPECT_EQ(world.machine.phase, Phase::kStopped);
  EXPECT_EQ(world.machine.state, kTearDown);
}

// --- depth first and breadth first ---

TEST(DepthFirst, VisitsTheSameNodesAsBreadthFirst) {
  Model model(testing::MachineOf(2), State(kActive));
  for (const ActuatorIndex i : model.kinds.Indices()) model.kinds[i] = i;  // no symmetry
  World root = NewWorld(model);
  Notes notes;
  Begin(model, root, false, notes);
  root.from = State(kSelfCheck);
  root.faults = root.faults_left = 1;
  SearchLimits limits;
  const Searched deep = SearchDepthFirst(model, root, limits);
  const Searched broad = SearchAll(model, root);
  EXPECT_FALSE(deep.fault);
  EXPECT_EQ(deep.figures.nodes, broad.figures.nodes);
  EXPECT_EQ(deep.figures.transitions, broad.figures.transitions);
  EXPECT_EQ(deep.figures.leaves, broad.figures.leaves);
}

TEST(FingerprintSet, HasEachFingerprintOnce) {
  FingerprintSet set;
  constexpr std::uint64_t kCount = 100'000;
  for (const bool is_new : {true, false}) {
    std::uint64_t inserted = 0;
    for (std::uint64_t i = 1; i <= kCount; ++i) inserted += set.Insert({i, i * i}) ? 1 : 0;
    EXPECT_EQ(inserted, is_new ? kCount : 0);
  }
  EXPECT_EQ(set.size(), kCount);
}

// --- rules of the user ---

UserRulesReading Read(const MachineConfig& config, const std::string& text) {
  return ReadUserRules(config, "rules.txt", text);
}

TEST(UserRules, AreReadFromLines) {
  const UserRulesReading read = Read(testing::MachineOf(2),
                                     "# a comment\n\nnever a Active while b is not Active  # why\n"
                                     "never machine LowPower while a is Active\nnever b Error\n");
  EXPECT_THAT(read.diagnostics, IsEmpty());
  ASSERT_EQ(read.rules.stable.size(), 3U);
  EXPECT_EQ(read.rules.stable[0].text, "never a Active while b is not Active");
  EXPECT_TRUE(read.rules.stable[0].condition_negated);
  EXPECT_FALSE(read.rules.stable[1].never.actuator);
  EXPECT_FALSE(read.rules.stable[2].condition);
}

TEST(UserRules, AreReportedWithThePlaceOfWhatIsWrong) {
  const UserRulesReading read =
      Read(testing::MachineOf(2),
           "never c Active\nnever a Actve\nalways a Active\n"
           "never a Active while b is\nnever a Active while b is Active now\n"
           "never a Active while b is Exited\nnever machine exited\n");
  std::vector<std::string> texts;
  for (const Diagnostic& one : read.diagnostics) texts.push_back(FormatDiagnostic(one));
  ASSERT_EQ(texts.size(), 7U);
  EXPECT_THAT(texts[0], HasSubstr("rules.txt:1:7: error: "));
  EXPECT_THAT(texts[1], HasSubstr("rules.txt:2:9: error: a has no state 'Actve'; did you mean"));
  EXPECT_THAT(texts[2], HasSubstr("rules.txt:3:1: error: expected 'never ACTUATOR STATE'"));
  EXPECT_THAT(texts[3], HasSubstr("rules.txt:4:26: error: expected"));
  EXPECT_THAT(texts[4], HasSubstr("rules.txt:5:34: error: expected"));
  EXPECT_THAT(texts[5], HasSubstr("b has no state 'Exited'; did you mean 'exited'?"));
  EXPECT_THAT(texts[6], HasSubstr("the machine has no state 'exited'"));
}

TEST(UserRules, DoNotNameAnActuatorThatIsCalledMachine) {
  MachineConfig config = testing::MachineOf(2);
  testing::ActuatorNamed(config, "b").name = "machine";
  const UserRulesReading read = Read(config, "never a Active while machine is Error\n");
  ASSERT_EQ(read.diagnostics.size(), 1U);
  EXPECT_THAT(FormatDiagnostic(read.diagnostics[0]),
              HasSubstr("rules.txt:1:22: error: 'machine' means the state of the machine"));
}

// The start has failed, and its processes stay for inspection.
TEST(UserRules, AreCheckedAfterAFailedStart) {
  Model model(testing::MachineOf(2));
  model.stable_rules = Read(model.config, "never machine SelfCheck while a is exited").rules.stable;
  World world = NewWorld(model);
  world.machine.phase = Phase::kFailed;
  world.machine.state = kSelfCheck;
  Notes notes;
  CheckRest(model, world, notes);
  EXPECT_THAT(notes.violations,
              ElementsAre("your rule: never machine SelfCheck while a is exited"));
}

// b stays on when a, which carries it, is lost; where b is bound to a, it does not.
TEST(UserRules, AreViolatedWithoutABindingAndHoldWithIt) {
  MachineConfig config = testing::Ours(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.on_lost = "Active";
  testing::ActuatorNamed(config, "a").restart.policy = RestartPolicy::kNo;
  ProofOptions options;
  options.from = State(kActive);
  options.stable_rules = Read(config, "never b Active while a is exited").rules.stable;
  const Proof without = ProofOf(config, 1, options);
  ASSERT_EQ(without.end, ProofEnd::kViolated);
  EXPECT_THAT(without.counter_example->violations,
              Contains("your rule: never b Active while a is exited"));
  testing::ActuatorNamed(config, "b").binds_to = {"a"};
  const Proof bound = ProofOf(config, 1, options);
  EXPECT_EQ(bound.end, ProofEnd::kProved) << Sentences(bound);
}

// Two actuators that are alike but for a rule.
TEST(UserRules, EndTheSymmetryOfWhatTheyName) {
  ProofOptions options;
  options.symmetry = true;
  const MachineConfig config = testing::MachineOf(2);
  const Proof alike = ProofOf(config, 0, options);
  options.stable_rules = Read(config, "never b Error while a is Active").rules.stable;
  const Proof named = ProofOf(config, 0, options);
  EXPECT_EQ(named.end, ProofEnd::kProved);
  EXPECT_GT(named.figures.nodes, alike.figures.nodes);
}

// --- searches of an earlier run ---

class Resuming : public ::testing::Test {
 protected:
  Resuming() {
    options_.from = State(kLowPower);
    options_.stable_rules = Read(config_, "never a OTA while b is Active").rules.stable;
    options_.on_finished = [this](const auto& finished) { finished_ = finished; };
  }
  void ExpectTheFiguresOf(const Proof& whole, const Proof& proof) const {
    EXPECT_EQ(proof.end, whole.end) << Sentences(proof);
    EXPECT_EQ(proof.tasks.size(), whole.tasks.size());
    EXPECT_EQ(proof.figures.nodes, whole.figures.nodes);
    EXPECT_EQ(proof.figures.transitions, whole.figures.transitions);
    ASSERT_EQ(proof.rule_coverage.size(), 1U);
    EXPECT_EQ(proof.rule_coverage[0].states, whole.rule_coverage[0].states);
    EXPECT_EQ(proof.rule_coverage[0].condition, whole.rule_coverage[0].condition);
  }

  const MachineConfig config_ = testing::MachineOf(2);
  ProofOptions options_;
  std::vector<ProvedTask> finished_;
};

TEST_F(Resuming, GivesTheFiguresOfAnUninterruptedProof) {
  const Proof whole = ProofOf(config_, 1, options_);
  ASSERT_EQ(whole.end, ProofEnd::kProved) << Sentences(whole);
  ASSERT_EQ(finished_.size(), whole.tasks.size());
  for (std::size_t i = 0; i < finished_.size(); i += 2) options_.earlier.push_back(finished_[i]);
  const Proof resumed = ProofOf(config_, 1, options_);
  ExpectTheFiguresOf(whole, resumed);
  const auto earlier = std::ranges::count_if(resumed.tasks, &ProvedTask::earlier);
  EXPECT_EQ(static_cast<std::size_t>(earlier), options_.earlier.size());
  EXPECT_EQ(finished_.size(), whole.tasks.size()) << "those of the earlier run are among them";
}

TEST_F(Resuming, MakesNoSearchTwice) {
  const Proof whole = ProofOf(config_, 1, options_);
  std::atomic<int> steps = 0;
  options_.rules.controller = [&](const auto& config, auto& machine, const Event& event, Time now) {
    ++steps;
    return Step(config, machine, event, now);
  };
  options_.earlier = finished_;
  ExpectTheFiguresOf(whole, ProofOf(config_, 1, options_));
  EXPECT_EQ(steps, 0);
}

TEST_F(Resuming, KeepsNoSearchThatWasInterrupted) {
  options_.on_progress = [](const ProofProgress& progress) {
    return progress.faults == 1 ? "the test has seen enough" : "";
  };
  const Proof proof = ProofOf(testing::MachineOf(3), 2, options_);
  ASSERT_EQ(proof.end, ProofEnd::kNotFinished);
  EXPECT_FALSE(finished_.empty());
  for (const ProvedTask& one : finished_) EXPECT_TRUE(one.finished) << one.task.Text();
  EXPECT_LT(finished_.size(), proof.tasks.size());
}

TEST_F(Resuming, CountsNoSearchThatIsNotFinished) {
  const Proof whole = ProofOf(config_, 0, options_);
  for (ProvedTask one : finished_) {
    one.finished = false;
    one.figures.nodes += 7;
    options_.earlier.push_back(one);
  }
  ExpectTheFiguresOf(whole, ProofOf(config_, 0, options_));
}

TEST_F(Resuming, FindsAViolationInWhatIsLeft) {
  const Proof without_fault = ProofOf(config_, 0, options_);
  ASSERT_EQ(without_fault.end, ProofEnd::kProved);
  options_.earlier = finished_;
  options_.rules = WithoutCrashes();
  const Proof proof = ProofOf(config_, 1, options_);
  ASSERT_EQ(proof.end, ProofEnd::kViolated);
  EXPECT_EQ(proof.counter_example->task.faults, 1);
  EXPECT_THAT(proof.counter_example->violations, Contains(HasSubstr("has exited in")));
}

// --- actuators that are alike ---

TEST(Symmetry, IsOfActuatorsThatAllOthersNeedAlike) {
  const Model model(WithLast());
  EXPECT_EQ(model.kinds[1], model.kinds[0]);
  EXPECT_NE(model.kinds[2], model.kinds[0]);
}

TEST(Symmetry, IsNotOfActuatorsOfWhichAThirdNeedsOne) {
  MachineConfig config = testing::MachineOf(3);
  testing::ActuatorNamed(config, "c").after = {"a"};
  const Model model(config);
  EXPECT_NE(model.kinds[1], model.kinds[0]);
}

TEST(Symmetry, IsNotOfActuatorsWithDifferentTimes) {
  MachineConfig config = testing::MachineOf(2);
  testing::ActuatorNamed(config, "b").times.front() = Milliseconds(200);
  const Model model(config);
  EXPECT_NE(model.kinds[1], model.kinds[0]);
}

// With and without it the same ends: all holds, with fewer nodes.
TEST(Symmetry, LeavesOutNodesAndNoViolation) {
  for (const MachineConfig& config : {testing::MachineOf(2), WithLast()}) {
    ProofOptions plain;
    ProofOptions symmetric;
    symmetric.symmetry = true;
    const int faults = config.actuators.size() == 2 ? 1 : 0;
    const Proof all = ProofOf(config, faults, plain);
    const Proof fewer = ProofOf(config, faults, symmetric);
    EXPECT_EQ(all.end, ProofEnd::kProved);
    EXPECT_EQ(fewer.end, ProofEnd::kProved);
    EXPECT_LT(fewer.figures.nodes, all.figures.nodes);
  }
}

TEST(Symmetry, FindsAPlantedFaultAsThePlainSearchDoes) {
  for (const bool symmetry : {false, true}) {
    ProofOptions options;
    options.symmetry = symmetry;
    options.rules = WithoutCrashes();
    const Proof proof = ProofOf(testing::MachineOf(2), 1, options);
    ASSERT_EQ(proof.end, ProofEnd::kViolated) << symmetry;
    EXPECT_EQ(proof.counter_example->steps.size(), 2U) << symmetry;
  }
}

// --- what is searched ---

TEST(SearchableConfig, HasOfThePolicyTheBatteryAloneAndNoOtherProtocol) {
  MachineConfig config = testing::Ours(2);
  config.policy.emplace();
  config.actuators[0].protocol = Protocol::kCyberdog;
  EXPECT_FALSE(SearchableConfig(config).policy);
  config.policy->low_power.emplace();
  config.policy->battery.emplace().protected_at = 31;
  const MachineConfig searched = SearchableConfig(config);
  ASSERT_TRUE(searched.policy);
  EXPECT_EQ(searched.policy->battery, config.policy->battery);
  EXPECT_FALSE(searched.policy->low_power);
  EXPECT_EQ(searched.actuators[0].command, searched.actuators[1].command);
}

// What a process may use is left out; without that two actuators of a host may be alike.
TEST(SearchableConfig, HasTheHostsOfItsActuators) {
  MachineConfig config = testing::Ours(3);
  config.hosts.push_back({"board", "10.0.0.2", "", "", ""});
  config.actuators[1].host = config.actuators[2].host = "board";
  config.actuators[2].limits.nice = 5;
  const Model model(SearchableConfig(config));
  EXPECT_THAT(model.hosts, ElementsAre("board"));
  EXPECT_EQ(model.kinds[2], model.kinds[1]);
  EXPECT_NE(model.kinds[1], model.kinds[0]);
}

TEST(SearchableConfig, SaysWhatIsLeftOutOfIt) {
  MachineConfig config = testing::Ours(2);
  EXPECT_THAT(LeftOutOf(config), IsEmpty());
  config.policy.emplace();
  config.permit = Milliseconds(200);
  config.capabilities.emplace_back();
  config.ros2.started_by_manager = true;
  config.transport = TransportProfile::kLan;
  config.keys = "/etc/keys";
  config.actuators[1].host = "board";
  config.actuators[0].restart.prevent_exit_codes = {2, 3};
  config.actuators[0].protocol = Protocol::kCyberdog;
  config.actuators[1].controller_lost = Milliseconds(5000);
  EXPECT_THAT(
      LeftOutOf(config),
      ElementsAre("[policy]", "[safety] permit_ms", "[capability]", "[ros2] start = \"manager\"",
                  "[transport]: actuators without `host` run on the controller's", "[security]",
                  "restart_prevent_exit_codes (a process ends without an exit code) of a",
                  "controller_lost_ms of b", "protocol (Musher's is searched) of a"));
}

TEST(SearchableConfig, IsOneOfAtMost32ActuatorsAndFromAStateThatItHas) {
  EXPECT_THAT(WhyNotSearchable(testing::MachineOf(2), std::nullopt), IsEmpty());
  EXPECT_THAT(WhyNotSearchable(testing::MachineOf(33), std::nullopt), HasSubstr("at most 32"));
  EXPECT_THAT(WhyNotSearchable(testing::MachineOf(2), State("Actve")),
              HasSubstr("did you mean 'Active'"));
}

}  // namespace musher::search::proof_test
