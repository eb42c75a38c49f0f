// What a ROS 2 process needs in its environment, and why it does not discover a machine without it.

#include "musher/transport/ros_environment.hpp"
#include "musher/test/support/paths.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

namespace musher::transport::ros_environment_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

constexpr auto kLocal = TransportProfile::kLocal;
constexpr auto kLan = TransportProfile::kLan;

// A node that was given what it needs, with `more` set.
Environment NodeOf(TransportProfile profile, Environment more = {}) {
  more.merge(RosEnvironment(profile, more));
  return more;
}

TEST(RosProcesses, GetTheLoopbackAndCyclone) {
  EXPECT_THAT(RosEnvironment(kLocal, {}),
              UnorderedElementsAre(Pair("CYCLONEDDS_URI", kRosOnLoopback),
                                   Pair("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")));
}

TEST(RosProcesses, GetTheLoopbackBeforeTheOuterInterfacesInTheProfileLan) {
  const Environment added = RosEnvironment(kLan, {}, {"eth0"});
  EXPECT_THAT(added, UnorderedElementsAre(Pair("CYCLONEDDS_URI", RosOnInterfaces({"eth0"})),
                                          Pair("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")));
  EXPECT_THAT(added.at("CYCLONEDDS_URI"),
              HasSubstr("<NetworkInterface name=\"lo\" multicast=\"true\"/>"
                        "<NetworkInterface name=\"eth0\" presence_required=\"false\"/>"));
}

TEST(RosProcesses, KeepWhatThePersonHasSet) {
  const Environment set = {{"CYCLONEDDS_URI", "file:///mine.xml"},
                           {"RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"}};
  EXPECT_THAT(RosEnvironment(kLocal, set), IsEmpty());
  EXPECT_EQ(RosEnvironment(kLocal, {{"CYCLONEDDS_URI", ""}}).size(), 2U);
}

TEST(RosProcesses, MeetTheMachineWithWhatTheyAreGiven) {
  for (const TransportProfile profile : {kLocal, kLan}) {
    EXPECT_THAT(RosObstacles(profile, {}, NodeOf(profile)), IsEmpty());
    EXPECT_THAT(RosObstacles(profile, {{"ROS_DOMAIN_ID", "7"}},
                             NodeOf(profile, {{"ROS_DOMAIN_ID", "7"},
                                              {"ROS_LOCALHOST_ONLY", "0"},
                                              {"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}})),
                IsEmpty());
  }
}

TEST(RosProcesses, AreNotMetForEachReasonThatIsKnown) {
  const auto why = [](const char* name, const char* value, TransportProfile profile = kLocal) {
    return RosObstacles(profile, {}, NodeOf(profile, {{name, value}}));
  };
  EXPECT_THAT(why("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"),
              ElementsAre(AllOf(HasSubstr("rmw_fastrtps_cpp"), HasSubstr("rmw_cyclonedds_cpp"))));
  EXPECT_THAT(why("ROS_DOMAIN_ID", "3"),
              ElementsAre("ROS_DOMAIN_ID is 3, but the machine is in domain 0; use the same one"));
  EXPECT_THAT(why("ROS_LOCALHOST_ONLY", "1", kLan), ElementsAre(HasSubstr("unset it")));
  EXPECT_THAT(why("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST", kLan),
              ElementsAre(HasSubstr("set SUBNET")));
  EXPECT_THAT(why("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"), ElementsAre(HasSubstr("OFF")));
  EXPECT_THAT(why("CYCLONEDDS_URI", "<CycloneDDS/>"),
              ElementsAre(AllOf(HasSubstr("does not name the interface lo"),
                                HasSubstr("profile = \"lan\""))));
}

TEST(RosProcesses, AreNotMetFromAShellWithoutAnySettings) {
  EXPECT_THAT(RosObstacles(kLocal, {}, {}), ElementsAre(HasSubstr("RMW_IMPLEMENTATION is not set"),
                                                        HasSubstr("CYCLONEDDS_URI is not set")));
}

// Of a person's own settings of Cyclone nothing is known.
TEST(RosProcesses, AreNotCheckedForTheInterfaceIfTheMachineHasItsOwnSettings) {
  const Environment both = {{"CYCLONEDDS_URI", "file:///mine.xml"},
                            {"RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"}};
  EXPECT_THAT(RosObstacles(kLocal, both, both), IsEmpty());
}

TEST(RosProcesses, AreNotWarnedOfAFileOfSettingsThatIsNotRead) {
  Environment node = NodeOf(kLocal);
  node["CYCLONEDDS_URI"] = "file:///etc/cyclonedds.xml";
  EXPECT_THAT(RosObstacles(kLocal, {}, node), IsEmpty());
}

TEST(RosProcesses, FindTheirSettingsAndTheMessagesOnThePageForUsersOfRos2) {
  std::ifstream file(SourceDir() + "/docs/ros2.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(page, HasSubstr(std::string("\nexport CYCLONEDDS_URI='") + kRosOnLoopback + "'\n"));
  EXPECT_THAT(page, HasSubstr("program 'ros2' not found in PATH" + MissingProgramHint("ros2")));
  const Environment node = {{"ROS_DOMAIN_ID", "3"},
                            {"ROS_LOCALHOST_ONLY", "1"},
                            {"ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"}};
  const auto obstacles = RosObstacles(kLocal, {}, node);
  EXPECT_THAT(obstacles, SizeIs(5));
  for (const std::string& obstacle : obstacles) {
    EXPECT_THAT(page, HasSubstr("`" + obstacle.substr(0, obstacle.find("set it to <"))));
  }
}

// A shell with the line for ROS 2's tools slowed the machine down that was started in it.
TEST(RosProcesses, ShareAShellWithAMachineOfTheProfileLocal) {
  EXPECT_FALSE(ReplacesProfile(kLocal, ""));
  EXPECT_FALSE(ReplacesProfile(kLocal, kRosOnLoopback));
  EXPECT_TRUE(ReplacesProfile(kLan, kRosOnLoopback));
  EXPECT_TRUE(ReplacesProfile(kLocal, "file:///mine.xml"));
  const std::string lan = RosOnInterfaces({"wlan0", "eth0"});
  EXPECT_FALSE(ReplacesProfile(kLan, lan));
  EXPECT_TRUE(ReplacesProfile(kLocal, lan));
  const Environment shell = NodeOf(kLocal);
  EXPECT_THAT(RosObstacles(kLocal, shell, shell), IsEmpty());
}

TEST(AMissingProgram, GetsAHintOnlyIfItIsRos2s) {
  EXPECT_EQ(MissingProgramHint("planner"), "");
  EXPECT_THAT(MissingProgramHint("ros2"), HasSubstr("/setup.sh"));
}

}  // namespace musher::transport::ros_environment_test
