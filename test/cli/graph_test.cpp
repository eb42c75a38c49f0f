#include "musher/cli/render/graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "musher/cli/render/svg.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::graph_test {

using ::testing::HasSubstr;

TEST(Graph, HasEachWayOfTheFlowOnce) {
  EXPECT_EQ(FlowTransitions(RobotConfig()),
            (std::vector<FlowTransition>{{"SetUp", "TearDown", false},
                                         {"SetUp", "SelfCheck", false},
                                         {"SelfCheck", "TearDown", false},
                                         {"Active", "TearDown", false},
                                         {"LowPower", "TearDown", false},
                                         {"Error", "TearDown", false},
                                         {"SelfCheck", "Active", false},
                                         {"SelfCheck", "Error", true},
                                         {"Active", "LowPower", true},
                                         {"Active", "Error", false},
                                         {"LowPower", "Error", false}}));
}

TEST(Graph, DrawsTheFlowWithRanksInDot) {
  const std::string dot = FlowDot(RobotConfig());
  EXPECT_THAT(dot, ::testing::StartsWith("digraph \"dog\" {\n"));
  EXPECT_THAT(dot, HasSubstr("  { rank=same; \"Active\" [label=\"Active\\nrank 6\"]; }\n"));
  EXPECT_THAT(dot, HasSubstr("  \"SetUp\" [style=\"rounded,dashed\"];\n"));
  EXPECT_THAT(dot, HasSubstr("  \"Active\" -> \"LowPower\" [dir=both];\n"));
  EXPECT_THAT(dot, HasSubstr("  \"Active\" -> \"Error\" [color=gray60];\n"));
  EXPECT_LT(dot.find("rank 6"), dot.find("rank 3"));  // the most active on top
}

TEST(Graph, DrawsTheFlowInMermaid) {
  EXPECT_EQ(FlowMermaid(RobotConfig()),
            "stateDiagram-v2\n"
            "  TearDown : TearDown (rank 0)\n"
            "  Active : Active (rank 6)\n"
            "  LowPower : LowPower (rank 3)\n"
            "  Error : Error (rank 1)\n"
            "  [*] --> SetUp\n"
            "  SetUp --> TearDown\n"
            "  SetUp --> SelfCheck\n"
            "  SelfCheck --> TearDown\n"
            "  Active --> TearDown\n"
            "  LowPower --> TearDown\n"
            "  Error --> TearDown\n"
            "  SelfCheck --> Active\n"
            "  SelfCheck --> Error\n"
            "  Error --> SelfCheck\n"
            "  Active --> LowPower\n"
            "  LowPower --> Active\n"
            "  Active --> Error\n"
            "  LowPower --> Error\n"
            "  TearDown --> [*]\n");
}

MachineConfig WithBoundEyes() {
  MachineConfig config = RobotConfig();
  config.actuators[1].binds_to = {"legs"};
  return config;
}

TEST(Graph, DrawsActuatorsByStageInDot) {
  EXPECT_EQ(ActuatorsDot(WithBoundEyes()),
            "digraph \"dog\" {\n"
            "  rankdir=LR;\n"
            "  node [shape=box, fontname=\"sans-serif\"];\n"
            "  subgraph cluster_stage_1 {\n"
            "    label=\"stage 1\";\n"
            "    \"legs\" [penwidth=2, label=\"legs\\ncritical\"];\n"
            "  }\n"
            "  subgraph cluster_stage_2 {\n"
            "    label=\"stage 2\";\n"
            "    \"eyes\";\n"
            "  }\n"
            "  \"legs\" -> \"eyes\";\n"
            "  \"legs\" -> \"eyes\" [style=dotted];\n"
            "}\n");
}

TEST(Graph, DrawsActuatorsByStageInMermaid) {
  EXPECT_EQ(ActuatorsMermaid(WithBoundEyes()),
            "flowchart LR\n"
            "  subgraph stage_1 [\"stage 1\"]\n"
            "    a_legs[\"legs<br/>critical\"]\n"
            "  end\n"
            "  subgraph stage_2 [\"stage 2\"]\n"
            "    a_eyes[\"eyes\"]\n"
            "  end\n"
            "  a_legs --> a_eyes\n"
            "  a_legs -.-> a_eyes\n");
}

class GraphCommand : public ::testing::Test {
 protected:
  GraphCommand() { std::ofstream(config_) << kRobotToml; }
  std::string Written(const std::string& name) const {
    std::ifstream file(folder_ / name);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  const TempFolder folder_;
  const std::string config_ = folder_ / "dog.toml";
};

TEST_F(GraphCommand, PrintsTheFlowInDotByDefault) {
  const Ran ran = RunProgram({"graph", config_});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_EQ(ran.out, FlowDot(RobotConfig()));
}

TEST_F(GraphCommand, WritesAFileInTheFormatOfItsName) {
  const Ran ran =
      RunProgram({"graph", config_, "--what", "actuators", "--output", folder_ / "x.mmd"});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_EQ(ran.out, "");
  EXPECT_EQ(Written("x.mmd"), ActuatorsMermaid(RobotConfig()));
}

TEST_F(GraphCommand, DrawsSvgThroughGraphviz) {
  if (std::system("dot -V 2>/dev/null") != 0) GTEST_SKIP() << "there is no Graphviz here";
  const Ran ran = RunProgram({"graph", config_, "-o", folder_ / "x.svg"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(Written("x.svg"), HasSubstr("</svg>"));
}

TEST_F(GraphCommand, NamesThePackageToInstallWithoutGraphviz) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder_.path().c_str(), 1);
  const Ran ran = RunProgram({"graph", config_, "--format", "svg"});
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(ran.exit, 2);
  EXPECT_EQ(ran.out, "");
  EXPECT_THAT(ran.err, HasSubstr("install the package graphviz"));
}

TEST_F(GraphCommand, ReportsAFileThatCannotBeWritten) {
  const Ran ran = RunProgram({"graph", config_, "-o", folder_ / "no/such/x.dot"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("no/such/x.dot"));
}

TEST_F(GraphCommand, RefusesABadConfigWithItsFaults) {
  std::ofstream(config_) << "nonsense";
  const Ran ran = RunProgram({"graph", config_, "--json"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr(R"("diagnostics":[{"file":)"));
  EXPECT_THAT(ran.err, HasSubstr(":1:"));
}

}  // namespace musher::cli::graph_test
