#include "musher/behavior/fsm/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "musher/behavior/fsm/machine.hpp"
#include "musher/test/behavior/fsm/logging_state.hpp"

namespace musher::fsm::check_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A chart, written as "A>B, B>A"; a name with ! is final, one with * is safe. The first is the
// start.
Chart Drawn(const std::vector<std::string>& states, const std::vector<std::string>& transitions) {
  Chart chart;
  chart.name = "show";
  chart.start = StateId{0};
  std::map<std::string, StateId> ids;
  for (std::string name : states) {
    Role role = Role::kNormal;
    if (name.back() == '!') role = Role::kFinal;
    if (name.back() == '*') role = Role::kSafe;
    if (role != Role::kNormal) name.pop_back();
    ids[name] = static_cast<StateId>(chart.states.size());
    chart.states.push_back({name, role, {}});
  }
  for (const std::string& transition : transitions) {
    const std::size_t arrow = transition.find('>');
    chart.transitions.push_back(
        {ids.at(transition.substr(0, arrow)), ids.at(transition.substr(arrow + 1)), ""});
  }
  return chart;
}

std::vector<std::string> ProblemsOf(const Chart& chart) {
  std::vector<std::string> lines;
  for (const Problem& problem : Check(chart)) {
    lines.push_back(SeverityName(problem.severity) + ": " + problem.where + ": " + problem.what);
  }
  return lines;
}

TEST(Check, FindsNothingInAShowThatAlwaysReturnsToItsStart) {
  EXPECT_THAT(
      ProblemsOf(Drawn({"IDLE", "PHOTO", "SAFE*"}, {"IDLE>PHOTO", "PHOTO>IDLE", "SAFE>IDLE"})),
      IsEmpty());
}

TEST(Check, FindsNothingInAMachineThatEnds) {
  EXPECT_THAT(ProblemsOf(Drawn({"A", "B", "END!"}, {"A>B", "B>END"})), IsEmpty());
}

TEST(Check, FindsNothingInAMachineOfOneState) {
  EXPECT_THAT(ProblemsOf(Drawn({"IDLE"}, {})), IsEmpty());
}

TEST(Check, FindsAStateThatNothingLeadsTo) {
  EXPECT_THAT(ProblemsOf(Drawn({"IDLE", "PHOTO"}, {"PHOTO>IDLE"})),
              ElementsAre("warning: PHOTO: only Force() reaches it: no transition leads to it"));
}

TEST(Check, TakesWhatOnlyTheSafeStateLeadsToAsReachable) {
  EXPECT_THAT(ProblemsOf(Drawn({"IDLE", "REST", "SAFE*"}, {"SAFE>REST", "REST>IDLE"})), IsEmpty());
}

TEST(Check, FindsADeadEndAndDoesNotReportTheStatesThatLeadThere) {
  EXPECT_THAT(
      ProblemsOf(Drawn({"A", "B", "C"}, {"A>B", "B>C"})),
      ElementsAre("error: C: is a dead end: it declares no transition out; make it final if it is "
                  "the end"));
}

TEST(Check, TakesAStateThatOnlyReentersItselfAsADeadEnd) {
  EXPECT_THAT(ProblemsOf(Drawn({"A", "B"}, {"A>B", "B>B"})), ::testing::SizeIs(1));
}

TEST(Check, FindsATrapOfStatesThatLeadOnlyToEachOther) {
  EXPECT_THAT(
      ProblemsOf(Drawn({"A", "B", "C", "D"}, {"A>B", "B>A", "B>C", "C>D", "D>C"})),
      ElementsAre("error: C: is in a trap: from C, D nothing leads to A, to a safe state or "
                  "to a final one"));
}

TEST(Check, AcceptsATransitionToTheSafeStateAsTheOnlyOneOut) {
  EXPECT_THAT(ProblemsOf(Drawn({"A", "B", "SAFE*"}, {"A>B", "B>SAFE", "SAFE>A"})), IsEmpty());
}

TEST(Check, FindsAFinalStateThatLeaves) {
  EXPECT_THAT(ProblemsOf(Drawn({"A", "END!"}, {"A>END", "END>A"})),
              ElementsAre("error: END: is final, but declares a transition to A"));
}

TEST(Check, WarnsOfASafeStateThatOnlyAForceOrAResetEnds) {
  EXPECT_THAT(
      ProblemsOf(Drawn({"A", "SAFE*"}, {})),
      ElementsAre(
          "warning: SAFE: declares no transition out: only a force or a reset ends a safe stop"));
}

TEST(Check, WarnsOfATransitionThatIsDeclaredTwiceWithTheSameTextOnly) {
  Chart chart = Drawn({"A", "B"}, {"A>B", "A>B", "B>A"});
  EXPECT_THAT(ProblemsOf(chart), ElementsAre("warning: A: declares its transition to B twice"));
  chart.transitions[1].when = "something else";
  EXPECT_THAT(ProblemsOf(chart), IsEmpty());
}

TEST(Check, ChecksMachinesInsideAndReportsThePath) {
  Chart outer = Drawn({"SHOW", "REST"}, {"SHOW>REST", "REST>SHOW"});
  Chart middle = Drawn({"X"}, {});
  middle.states[0].inside.push_back(Drawn({"A", "B"}, {"A>B"}));
  outer.states[0].inside.push_back(middle);
  EXPECT_THAT(ProblemsOf(outer),
              ElementsAre("error: SHOW/X/B: is a dead end: it declares no transition out; "
                          "make it final if it is the end"));
}

TEST(Check, RefusesAChartWithoutAStart) {
  EXPECT_THAT(ProblemsOf(Chart{.name = "show", .states = {}, .transitions = {}, .start = kNoState}),
              ElementsAre("error: show: has no start state"));
}

TEST(CheckedMachine, IsNotBuiltWithADeadEndAndKeepsItsWarnings) {
  Log log;
  Machine stuck({.name = "show"});
  stuck.Add("A", std::make_unique<LoggingState>("A", log, std::vector<std::string>{"B"}));
  stuck.Add("B", std::make_unique<LoggingState>("B", log));
  const Result<> built = stuck.Build("A");
  ASSERT_FALSE(built);
  EXPECT_EQ(
      built.error().message,
      "show: B: is a dead end: it declares no transition out; make it final if it is the end");

  Machine machine({.name = "show"});
  machine.Add("A", std::make_unique<LoggingState>("A", log));
  machine.Add("B", std::make_unique<LoggingState>("B", log));
  ASSERT_TRUE(machine.Build("A"));
  EXPECT_THAT(machine.warnings(),
              ElementsAre("B: only Force() reaches it: no transition leads to it"));
}

}  // namespace musher::fsm::check_test
