// `musher new ros2`: a config from the parameter files of a nav2 stack.

#include "musher/cli/nav2/nav2_config.hpp"

#include <gmock/gmock.h>

#include "musher/cli/nav2/params_file.hpp"
#include "musher/lifecycle/config/config_toml.hpp"

namespace musher::cli::nav2_config_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kManaged = R"(# of a robot
lifecycle_manager_navigation:
  ros__parameters:
    autostart: true   # at once
    bond_timeout: 4.0
    node_names: ['map_server', "amcl",
                 planner_server]
amcl:
  ros__parameters:
    alpha1: 0.2
    scan_topic: "scan # one"
planner_server:
  ros__parameters:
    planner_plugins: ["GridBased"]
    GridBased:
      plugin: "nav2_navfn_planner::NavfnPlanner"
)";

// The machine that `musher up` would run.
MachineConfig Read(const std::vector<NamedText>& files) {
  const auto text = Nav2Config(files, "robot");
  EXPECT_TRUE(text) << text.error().message;
  const auto reading = ReadConfigText(text.value(), "robot.toml");
  for (const Diagnostic& one : reading.diagnostics) ADD_FAILURE() << one.message;
  return reading.config.value_or(MachineConfig());
}

std::vector<std::string> NamesOf(const MachineConfig& config) {
  std::vector<std::string> names;
  for (const ActuatorConfig& actuator : config.actuators) names.push_back(actuator.name);
  return names;
}

TEST(AConfigFromNav2sParameters, HasTheNodesOfTheManagerInItsOrder) {
  const MachineConfig config = Read({{"nav2.yaml", kManaged}});
  EXPECT_THAT(NamesOf(config), ElementsAre("map_server", "amcl", "planner_server"));
  for (const ActuatorConfig& actuator : config.actuators) {
    EXPECT_EQ(actuator.protocol, Protocol::kRos2Lifecycle);
    EXPECT_TRUE(actuator.critical);
    EXPECT_EQ(actuator.checkpoint, Milliseconds(4000)) << "its bond";
  }
  EXPECT_THAT(config.actuators[0].after, IsEmpty());
  EXPECT_THAT(config.actuators[2].after, ElementsAre("amcl"));
  EXPECT_THAT(config.actuators[1].command,
              ElementsAre("ros2", "run", "nav2_amcl", "amcl", "--ros-args", "-r", "__node:=amcl",
                          "--params-file", "nav2.yaml"));
  EXPECT_THAT(config.actuators[0].command, Not(::testing::Contains("nav2.yaml")))
      << "it has no parameters there";
}

TEST(AConfigFromNav2sParameters, HasTheServersOfNav2WhereNoManagerIsListed) {
  const MachineConfig config = Read({{"a.yaml",
                                      "bt_navigator:\n  ros__parameters:\n    a: 1\n"
                                      "amcl:\n  ros__parameters:\n    a: 1\n"
                                      "local_costmap:\n  local_costmap:\n    ros__parameters:\n"
                                      "      plugins:\n      - \"a\"\n      - b\n"}});
  EXPECT_THAT(NamesOf(config), ElementsAre("amcl", "bt_navigator"));
  EXPECT_FALSE(config.actuators[0].checkpoint) << "no bond is known";
}

TEST(AConfigFromNav2sParameters, MarksWhatAPersonHasToFillIn) {
  const auto text = Nav2Config(
      {{"m.yaml", "m:\n  ros__parameters:\n    node_names:\n    - my_server\n"}}, "robot");
  ASSERT_TRUE(text);
  EXPECT_THAT(text.value(), AllOf(HasSubstr("\"PACKAGE\", \"PROGRAM\""), HasSubstr("# fill in")));
}

TEST(AConfigFromNav2sParameters, IsRefusedWithThePlaceOfTheFault) {
  const auto refusal = [](const std::string& text) {
    const auto config = Nav2Config({{"a.yaml", text}}, "robot");
    return config ? "" : config.error().message;
  };
  EXPECT_THAT(refusal("amcl:\n  ros__parameters:\n  what is this\n"), HasSubstr("a.yaml:3: "));
  EXPECT_THAT(refusal("a: 1\n"), HasSubstr("no lifecycle manager"));
  EXPECT_THAT(refusal("m:\n  ros__parameters:\n    node_names: ['a\"b']\n"),
              HasSubstr("is no name of a ROS 2 node"));
}

TEST(AParameterFile, IsReadUpToItsOddParts) {
  const auto tree = ReadParams(
      "a:\n  text: |\n    many: lines\n    of it\n  'quoted key': 'x: y'\n  list: [1, 2,\n    3]\n"
      "  after: yes\nb:\n- one\n- two: 2\n  three: 3\n",
      "a.yaml");
  ASSERT_TRUE(tree) << tree.error().message;
  const ParamsNode* a = tree.value().Find("a");
  ASSERT_NE(a, nullptr);
  EXPECT_EQ(a->Find("quoted key")->text, "x: y");
  EXPECT_THAT(a->Find("list")->list, ElementsAre("1", "2", "3"));
  EXPECT_EQ(a->Find("after")->text, "yes");
  EXPECT_EQ(tree.value().Find("b")->list.front(), "one");
}

TEST(AParameterFile, OfAnyBytesIsReadOrRefused) {
  for (const char* text : {"", ":", "[", "a: [", "a:\n\tb: 1", "- a", "'", "a: 'b", "#",
                           "\xff: \xfe", "a:\n    b:\n  c: 1", "a: b: c: d"}) {
    static_cast<void>(ReadParams(text, "a.yaml").ok());
  }
}

}  // namespace musher::cli::nav2_config_test
