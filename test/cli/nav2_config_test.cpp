// `musher new ros2`: a config from the parameter files of a nav2 stack.

#include "musher/cli/nav2/nav2_config.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "musher/base/files.hpp"
#include "musher/cli/nav2/params_file.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::nav2_config_test {

using ::testing::AllOf;
using ::testing::Contains;
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
  EXPECT_THAT(config.actuators[0].command, Not(Contains("nav2.yaml")))
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

std::string WithAutostart(const std::string& line) {
  return "manager:\n  ros__parameters:\n" + line + "    node_names: [amcl]\n";
}

// nav2's manager waits for a call then, and the robot stands.
TEST(AConfigFromNav2sParameters, WaitsForAManagerWhereNav2DoesNotStartByItself) {
  const auto waits = [](const std::string& line) {
    return Read({{"a.yaml", WithAutostart(line)}}).ros2.started_by_manager;
  };
  EXPECT_TRUE(waits("    autostart: false\n"));
  EXPECT_TRUE(waits("")) << "its default";
  EXPECT_TRUE(waits("    autostart: $(var autostart)\n")) << "not known here";
  EXPECT_FALSE(waits("    autostart: True\n"));
  const auto text = Nav2Config({{"a.yaml", WithAutostart("")}}, "robot");
  ASSERT_TRUE(text);
  EXPECT_THAT(text.value(), HasSubstr("no `autostart: true`"));
  EXPECT_THAT(Nav2Config({{"nav2.yaml", kManaged}}, "robot").value(), Not(HasSubstr("[ros2]")));
}

// ROS 2 joins the blocks of all files that are for a node.
TEST(AConfigFromNav2sParameters, WaitsForAManagerByAllBlocksThatAreForIt) {
  const auto waits = [](const std::string& first, const std::string& second) {
    return Read({{"a.yaml", first}, {"b.yaml", second}}).ros2.started_by_manager;
  };
  const auto block = [](const std::string& key, const std::string& line) {
    return key + ":\n  ros__parameters:\n    " + line + "\n";
  };
  const std::string amcl = block("amcl", "a: 1");
  EXPECT_TRUE(waits(block("manager", "autostart: false"), amcl)) << "a launch file has the names";
  EXPECT_FALSE(waits(block("manager", "autostart: true"), amcl));
  EXPECT_TRUE(waits(WithAutostart("    autostart: true\n"), block("manager", "autostart: false")));
  EXPECT_FALSE(waits(WithAutostart(""), block("/**", "autostart: true")));
  EXPECT_FALSE(waits(block("manager", "autostart: true"), WithAutostart("")));
  EXPECT_TRUE(waits(WithAutostart(""), block("other", "autostart: true")));
}

// Of a manager that starts and one that does not.
TEST(AConfigFromNav2sParameters, WaitsForAManagerWhereOneOfTwoDoesNotStartByItself) {
  const std::string other = "second:\n  ros__parameters:\n    node_names: [map_server]\n";
  EXPECT_TRUE(Read({{"a.yaml", WithAutostart("    autostart: true\n")}, {"b.yaml", other}})
                  .ros2.started_by_manager);
}

// A node in the root would have none of the parameters: amcl then runs with its defaults.
TEST(AConfigFromNav2sParameters, KeepsTheNamespaceOfTheNodes) {
  const std::string nested =
      "/dog1:\n  manager:\n    ros__parameters:\n      node_names: [amcl]\n"
      "  amcl:\n    ros__parameters:\n      a: 1\n";
  const std::string full =
      "/dog1/manager:\n  ros__parameters:\n    node_names: [amcl]\n"
      "/dog1/amcl:\n  ros__parameters:\n    a: 1\n";
  const std::string servers = "dog1/amcl:\n  ros__parameters:\n    a: 1\n";
  for (const std::string& text : {nested, full, servers}) {
    const MachineConfig config = Read({{"a.yaml", text}});
    EXPECT_EQ(config.name_space, "dog1") << text;
    ASSERT_THAT(NamesOf(config), ElementsAre("amcl")) << text;
    EXPECT_THAT(config.actuators[0].command,
                ElementsAre("ros2", "run", "nav2_amcl", "amcl", "--ros-args", "-r", "__node:=amcl",
                            "-r", "__ns:=/dog1", "--params-file", "a.yaml"))
        << text;
  }
}

TEST(AConfigFromNav2sParameters, GivesANodeTheFilesOfItsOwnNamespaceOnly) {
  const MachineConfig config =
      Read({{"m.yaml", "/dog1/manager:\n  ros__parameters:\n    node_names: [amcl]\n"},
            {"root.yaml", "amcl:\n  ros__parameters:\n    a: 1\n"},
            {"all.yaml", "/**:\n  ros__parameters:\n    a: 1\n"},
            {"any.yaml", "/*/amcl:\n  ros__parameters:\n    a: 1\n"}});
  ASSERT_EQ(config.actuators.size(), 1U);
  const std::vector<std::string>& command = config.actuators[0].command;
  EXPECT_THAT(command, Contains("all.yaml"));
  EXPECT_THAT(command, Contains("any.yaml"));
  EXPECT_THAT(command, Not(Contains("root.yaml"))) << "ROS 2 does not read it for /dog1/amcl";
}

TEST(AConfigFromNav2sParameters, MarksANodeWithoutParameters) {
  const auto text = Nav2Config({{"a.yaml", WithAutostart("")}}, "robot");
  ASSERT_TRUE(text);
  EXPECT_THAT(text.value(), HasSubstr("# no file has parameters of it"));
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
              HasSubstr("in node_names is not a name of letters"));
  EXPECT_THAT(refusal("m:\n  ros__parameters:\n    node_names: ['3d_camera']\n"),
              HasSubstr("begins with no digit"));
  EXPECT_THAT(refusal("/dog1/amcl:\n  ros__parameters:\n    a: 1\n"
                      "/dog2/amcl:\n  ros__parameters:\n    a: 1\n"),
              HasSubstr("/dog1/amcl and /dog2/amcl are in different namespaces"));
  EXPECT_THAT(refusal("/a\"b/amcl:\n  ros__parameters:\n    a: 1\n"),
              HasSubstr("is no namespace of ROS 2"));
}

class TheCommandNewRos2 : public ::testing::Test {
 protected:
  std::string File(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  Ran New(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"new", "ros2"});
    arguments.insert(arguments.end(), {"--output", folder_ / "dog.toml"});
    return RunProgram(arguments);
  }

  const TempFolder folder_;
};

TEST_F(TheCommandNewRos2, MakesAConfigOfTheFilesNamedAfterItsOwn) {
  const std::string manager = File("manager.yaml", kManaged);
  const std::string amcl = File("amcl.yaml", "amcl:\n  ros__parameters:\n    alpha2: 0.1\n");
  const Ran made = New({manager, amcl});
  EXPECT_EQ(made.exit, 0) << made.err;
  EXPECT_EQ(made.out, (folder_ / "dog.toml") + " is made: read its comments, then `musher check " +
                          (folder_ / "dog.toml") + "`\n");
  const auto reading = ReadConfigText(ReadFile(folder_ / "dog.toml"), "dog.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->name, "dog");
  EXPECT_THAT(reading.config->actuators[1].command, AllOf(Contains(manager), Contains(amcl)));
}

TEST_F(TheCommandNewRos2, ReplacesNoFile) {
  const std::string manager = File("manager.yaml", kManaged);
  File("dog.toml", "# edited");
  const Ran refused = New({manager});
  EXPECT_NE(refused.exit, 0);
  EXPECT_THAT(refused.err, HasSubstr("dog.toml exists already; choose another --output"));
  EXPECT_EQ(ReadFile(folder_ / "dog.toml"), "# edited");
  std::filesystem::remove(folder_ / "dog.toml");
  std::filesystem::create_symlink("nowhere", (folder_ / "dog.toml"));
  EXPECT_NE(New({manager}).exit, 0) << "a link to a file that does not exist yet";
}

TEST_F(TheCommandNewRos2, NamesAFileThatItCannotRead) {
  const Ran refused = New({folder_ / "absent.yaml"});
  EXPECT_NE(refused.exit, 0);
  EXPECT_THAT(refused.err, HasSubstr("absent.yaml cannot be read, or has no parameters"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "dog.toml"));
}

TEST_F(TheCommandNewRos2, AnswersAScript) {
  const std::string manager = File("manager.yaml", kManaged);
  EXPECT_EQ(New({manager, "--json"}).out, "{\"config\":\"" + (folder_ / "dog.toml") + "\"}\n");
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
