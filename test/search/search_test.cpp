// A machine of three actuators, from each state to each state, in every order of events and with
// every fault at every point: the gate has one fault, the nightly run also pairs of them. By hand:
//
//   MUSHER_SEARCH_FAULTS=2   this number of faults instead
//   MUSHER_SEARCH_TARGET=s   only to this state
//   MUSHER_SEARCH_PATH=0.3   with a target: prints the scenario of this path instead of a search
//   MUSHER_REPORT_DIR=dir    the figures as files

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "musher/search/explorer.hpp"
#include "musher/test/search/figures_table.hpp"
#include "musher/test/search/scenarios.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::search::search_test {

std::string Environment(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value != nullptr ? value : "";
}

// Prints the table when all tests of this process have ended.
class TablePrinter : public ::testing::Environment {
 public:
  void TearDown() override { table.Publish(); }
  FiguresTable table;
};
TablePrinter* const kTable =
    static_cast<TablePrinter*>(::testing::AddGlobalTestEnvironment(new TablePrinter));

// With a sanitizer the search is ten times slower, and finds other errors anyway.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kFewerFaults = 1;
#else
constexpr int kFewerFaults = 0;
#endif

int FaultsOf(const Scenario& scenario) {
  const std::string wanted = Environment("MUSHER_SEARCH_FAULTS");
  if (!wanted.empty()) return std::stoi(wanted);
  return std::min(scenario.faults, musher::testing::Nightly() ? 2 : 1) - kFewerFaults;
}

class ExhaustiveSearch : public ::testing::TestWithParam<std::tuple<std::string, State>> {
 protected:
  const Scenario& scenario() const { return ScenarioNamed(std::get<0>(GetParam())); }
  const State& from() const { return std::get<1>(GetParam()); }
  int faults() const { return FaultsOf(scenario()); }

  Figures SearchTo(const State& to) const {
    const Model model(scenario().config, to);
    World root = WorldIn(model, from());
    root.faults = root.faults_left = faults();
    if (const std::string path = Environment("MUSHER_SEARCH_PATH"); !path.empty()) {
      std::cout << ScenarioOf(model, root, path);
      return {};
    }
    const Searched searched = SearchAll(model, root);
    if (searched.fault) {
      const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
      ADD_FAILURE() << "from " << from() << " to " << to << "\n"
                    << ScenarioOf(model, root, searched.fault->path)
                    << "replay with: MUSHER_SEARCH_FAULTS=" << faults()
                    << " MUSHER_SEARCH_TARGET=" << to
                    << " MUSHER_SEARCH_PATH=" << searched.fault->path
                    << " search_test --gtest_filter=" << test->test_suite_name() << "."
                    << test->name();
    }
    return searched.figures;
  }
};

TEST_P(ExhaustiveSearch, FindsNoViolation) {
  const std::string only = Environment("MUSHER_SEARCH_TARGET");
  Figures figures;
  for (const State& to : AllStates()) {
    if (IsPermitted(from(), to) && (only.empty() || to == only)) figures += SearchTo(to);
  }
  kTable->table.Add(scenario().name, from(), faults(), figures);
}

// Of a machine with a state that is as active as Active: between the two, and from and to a lower
// one.
TEST(ExhaustiveSearchOfEqualRanks, FindsNoViolation) {
  const std::vector<std::pair<State, State>> pairs = {{"Active", "Dancing"},
                                                      {"Dancing", "Active"},
                                                      {"Dancing", "Protected"},
                                                      {"Protected", "Dancing"}};
  for (const auto& [from, to] : pairs) {
    Model model(EqualRanks().config, to);
    model.releases = true;
    World root = WorldIn(model, from);
    // An emergency stop and a restart of the controller cross the switch on the level.
    const bool pairs_of_faults = musher::testing::Nightly() && from == "Active";
    const int more = pairs_of_faults && FaultsOf(EqualRanks()) == 1 ? 1 : 0;
    root.faults = root.faults_left = FaultsOf(EqualRanks()) + more;
    const Searched searched = SearchAll(model, root);
    EXPECT_FALSE(searched.fault) << "from " << from << " to " << to << "\n"
                                 << ScenarioOf(model, root, searched.fault->path);
    EXPECT_GT(searched.figures.nodes, FaultsOf(EqualRanks()) == 0 ? 1U : 100U);
  }
}

// Around an emergency stop, with actuators that are restarted and a controller that is killed:
// after its release nothing is switched on before a person requests it.
TEST(ExhaustiveSearchOfAStopAndRestarts, FindsNoViolation) {
  const std::vector<std::pair<State, State>> switches = {
      {"Active", "Active"}, {"LowPower", "Active"}, {"Active", "LowPower"}};
  for (const auto& [from, to] : switches) {
    if (from != to && !musher::testing::Nightly()) continue;  // half a minute
    Model model(ScenarioNamed("Restarted").config, to);
    model.releases = true;
    model.faults = OnlyFaults({ChoiceKind::kEngageStop, ChoiceKind::kCrash, ChoiceKind::kRestart});
    World root = WorldIn(model, from);
    root.faults = root.faults_left =
        (from == to && musher::testing::Nightly() ? 3 : 2) - kFewerFaults;
    const Searched searched = SearchAll(model, root);
    EXPECT_FALSE(searched.fault) << "from " << from << " to " << to << "\n"
                                 << ScenarioOf(model, root, searched.fault->path);
    std::cout << from << " to " << to << ": " << searched.figures.nodes << " nodes\n";
  }
}

// The same where the release crosses what is under way: a rollback, a restarted actuator's checks.
TEST(ExhaustiveSearchOfAReleaseAtAnyPoint, FindsNoViolation) {
  Model model(ScenarioNamed("Restarted").config, State(kActive));
  model.releases = model.releases_early = true;
  model.faults = OnlyFaults({ChoiceKind::kEngageStop, ChoiceKind::kCrash, ChoiceKind::kHold});
  World root = WorldIn(model, State(kActive));
  root.faults = root.faults_left = 2 - kFewerFaults;
  const Searched searched = SearchAll(model, root);
  EXPECT_FALSE(searched.fault) << ScenarioOf(model, root, searched.fault->path);
  std::cout << searched.figures.nodes << " nodes\n";
}

// Beside another machine, or a controller that was replaced, whose messages have no identity: their
// commands, releases and heartbeats change nothing, at any point of a switch with another fault.
TEST(ExhaustiveSearchBesideAnotherMachine, FindsNoViolation) {
  const std::vector<std::pair<State, State>> switches = {
      {"LowPower", "Active"}, {"Active", "LowPower"}, {"Active", "TearDown"}};
  for (const auto& [from, to] : switches) {
    Model model(ScenarioNamed("Chain").config, to);
    model.releases = model.other_machine = true;
    World root = WorldIn(model, from);
    root.faults = root.faults_left = FaultsOf(ScenarioNamed("Chain"));
    const Searched searched = SearchAll(model, root);
    EXPECT_FALSE(searched.fault) << "from " << from << " to " << to << "\n"
                                 << ScenarioOf(model, root, searched.fault->path);
    std::cout << from << " to " << to << ": " << searched.figures.nodes << " nodes\n";
  }
}

// With an actuator on another host, whose link is cut and works again, and which boots again.
TEST(ExhaustiveSearchOfTwoHosts, FindsNoViolation) {
  std::vector<std::pair<State, State>> switches = {
      {"Active", "Active"}, {"Active", "LowPower"}, {"LowPower", "Active"}, {"Active", "TearDown"}};
  if (musher::testing::Nightly()) {
    switches.emplace_back("Protected", "DeActive");
    switches.emplace_back("DeActive", "Active");
    switches.emplace_back("Active", "SelfCheck");
  }
  for (const auto& [from, to] : switches) {
    const Model model(TwoHosts().config, to);
    World root = WorldIn(model, from);
    root.faults = root.faults_left = FaultsOf(TwoHosts());
    const Searched searched = SearchAll(model, root);
    EXPECT_FALSE(searched.fault) << "from " << from << " to " << to << "\n"
                                 << ScenarioOf(model, root, searched.fault->path);
    std::cout << from << " to " << to << ": " << searched.figures.nodes << " nodes\n";
  }
}

// While the start leads to Active. Where b is critical, it can fail there.
TEST(ExhaustiveSearchOfAStart, FindsNoViolation) {
  for (const Scenario& scenario : Scenarios()) {
    const Model model(scenario.config);
    World root = WorldInStart(model);
    root.faults = root.faults_left = FaultsOf(scenario);
    const Searched searched = SearchAll(model, root);
    EXPECT_FALSE(searched.fault) << scenario.name << "\n"
                                 << ScenarioOf(model, root, searched.fault->path);
    std::cout << scenario.name << ": " << searched.figures.nodes << " nodes\n";
  }
}

TEST_P(ExhaustiveSearch, RefusesExactlyWhatTheFlowDoesNotPermit) {
  for (const State& to : AllStates()) {
    const Model model(scenario().config, to);
    World world = WorldIn(model, from());
    const World before = world;
    Notes notes;
    notes.log = true;
    RequestSwitch(model, world, to, notes);
    const std::string refused = "  request 1 gets: refused in " + from();
    const auto refusals = std::count(notes.scenario.begin(), notes.scenario.end(), refused);
    EXPECT_EQ(refusals, IsPermitted(from(), to) ? 0 : 1) << from() << " to " << to;
    EXPECT_THAT(notes.violations, ::testing::IsEmpty());
    if (IsPermitted(from(), to)) continue;
    EXPECT_EQ(world.machine.state, before.machine.state);
    EXPECT_EQ(world.machine.number, before.machine.number) << "something was sent";
    EXPECT_EQ(world.machine.actuators, before.machine.actuators);
  }
}

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const Scenario& scenario : Scenarios()) names.push_back(scenario.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Of, ExhaustiveSearch,
                         ::testing::Combine(::testing::ValuesIn(Names()),
                                            ::testing::ValuesIn(AllStates())),
                         [](const auto& which) {
                           return std::get<0>(which.param) + "From" +
                                  std::get<1>(which.param).name();
                         });

}  // namespace musher::search::search_test
