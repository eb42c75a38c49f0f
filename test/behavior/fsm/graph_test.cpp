#include "musher/behavior/fsm/graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::fsm::graph_test {

using ::testing::HasSubstr;
using ::testing::Not;

Chart Photo() {
  return {.name = "photo",
          .states = {{"CONFIRM", Role::kNormal, {}}, {"DONE", Role::kFinal, {}}},
          .transitions = {{StateId{0}, StateId{1}, "yes"}},
          .start = StateId{0}};
}

Chart Show() {
  return {.name = "show",
          .states = {{"IDLE", Role::kNormal, {}},
                     {"PHOTO", Role::kNormal, {Photo()}},
                     {"SAFE_STOP", Role::kSafe, {}}},
          .transitions = {{StateId{0}, StateId{1}, "a heart is seen"},
                          {StateId{1}, StateId{0}, "finished"},
                          {StateId{1}, StateId{1}, "again"},
                          {StateId{2}, StateId{0}, ""}},
          .start = StateId{0}};
}

TEST(Dot, DrawsStatesRolesTransitionsAndTheMachineInside) {
  EXPECT_EQ(ToDot(Show(), "PHOTO/CONFIRM"), R"(digraph "show" {
  compound=true;
  node [shape=box, style="rounded,filled", fillcolor=white, fontname="sans-serif"];
  edge [fontname="sans-serif", fontsize=10];
  sstart [shape=point, fillcolor=black, label=""];
  s0 [label="IDLE"];
  subgraph cluster_s1 {
    graph [label="PHOTO", fontname="sans-serif", style="rounded,filled", fillcolor=lightyellow, penwidth=2];
    s1_start [shape=point, fillcolor=black, label=""];
    s1_0 [label="CONFIRM", fillcolor=gold, penwidth=2];
    s1_1 [label="DONE", peripheries=2];
    s1_start -> s1_0;
    s1_0 -> s1_1 [label="yes"];
  }
  s2 [label="SAFE_STOP", shape=octagon, style=filled, color=firebrick];
  sstart -> s0;
  s0 -> s1_start [label="a heart is seen", lhead=cluster_s1];
  s1_start -> s0 [label="finished", ltail=cluster_s1];
  s1_start -> s1_start [label="again"];
  s2 -> s0;
}
)");
}

TEST(Mermaid, DrawsStatesRolesTransitionsAndTheMachineInside) {
  EXPECT_EQ(ToMermaid(Show(), "PHOTO/CONFIRM"), R"(stateDiagram-v2
  state "IDLE" as s0
  state "PHOTO" as s1 {
    state "CONFIRM" as s1_0
    state "DONE" as s1_1
    [*] --> s1_0
    s1_0 --> s1_1 : yes
    s1_1 --> [*]
  }
  state "SAFE_STOP" as s2
  [*] --> s0
  s0 --> s1 : a heart is seen
  s1 --> s0 : finished
  s1 --> s1 : again
  s2 --> s0
  classDef safe stroke:#b22222,stroke-width:2px
  classDef present fill:#ffd700,color:#000000
  class s1 present
  class s1_0 present
  class s2 safe
)");
}

TEST(Graph, MarksNothingWhenNothingIsPresent) {
  EXPECT_THAT(ToDot(Show()), Not(HasSubstr("gold")));
  EXPECT_THAT(ToMermaid(Show()), Not(HasSubstr("class s1 present")));
}

// Two machines may have states with the same name.
TEST(Graph, MarksAnInnerStateOnlyInTheStateThatIsPresent) {
  Chart chart = Show();
  chart.states[0].inside.push_back(Photo());
  EXPECT_THAT(ToMermaid(chart, "IDLE/DONE"), HasSubstr("class s0_1 present"));
  EXPECT_THAT(ToMermaid(chart, "IDLE/DONE"), Not(HasSubstr("class s1_1 present")));
  EXPECT_THAT(ToMermaid(chart, "IDLE"), Not(HasSubstr("_0 present")));
}

TEST(Dot, TakesAnyNameAndAnyWords) {
  Chart chart = Show();
  chart.name = "a \"show\"";
  chart.states[0].name = "\\N & \"x\"";
  chart.transitions[0].when = "one\ntwo\x01";
  const std::string dot = ToDot(chart);
  EXPECT_THAT(dot, HasSubstr(R"(digraph "a \"show\"" {)"));
  EXPECT_THAT(dot, HasSubstr(R"(s0 [label="\\N &amp; \"x\""])"));
  EXPECT_THAT(dot, HasSubstr(R"([label="one\ntwo ")"));
}

TEST(Mermaid, TakesAnyNameAndAnyWords) {
  Chart chart = Show();
  chart.states[0].name = "a \"b\"; c";
  chart.transitions[0].when = "x: 1 < 2\n%% #{} & \\ `";
  const std::string text = ToMermaid(chart);
  EXPECT_THAT(text, HasSubstr("state \"a #34;b#34;#59; c\" as s0\n"));
  EXPECT_THAT(text, HasSubstr(" : x#58; 1 #60; 2 #37;#37; #35;#123;#125; #38; #92; #96;\n"));
}

TEST(Graph, DrawsAChartWithoutAStart) {
  const Chart empty{.name = "none", .states = {}, .transitions = {}, .start = kNoState};
  EXPECT_THAT(ToDot(empty), HasSubstr("digraph \"none\""));
  EXPECT_EQ(ToMermaid(empty), "stateDiagram-v2\n");
}

}  // namespace musher::fsm::graph_test
