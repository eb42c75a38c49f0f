// The motion id table: the installed one matches the robot's, and errors are reported with a
// place.

#include <gmock/gmock.h>

#include <map>
#include <numbers>
#include <set>

#include "musher/lifecycle/actuator/capability.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/modules/motion/motion_config.hpp"
#include "musher/modules/motion/motion_table.hpp"
#include "musher/test/modules/motion/harness.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::motion::testing::motion_table_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST(MotionTable, HasEveryMotionOfTheRobot) {
  EXPECT_EQ(TheTable().motions().size(), 134U);
  for (const std::int32_t id : {0,   101, 102, 111, 112, 121, 138, 171, 179, 199,
                                214, 303, 311, 343, 345, 392, 400, 401, 505, 513}) {
    EXPECT_NE(TheTable().Find(id), nullptr) << id;
  }
  for (const std::int32_t id : {-1, 1, 100, 116, 204, 312, 349, 514}) {
    EXPECT_EQ(TheTable().Find(id), nullptr) << id;
  }
}

struct Row {
  std::int32_t id;
  int mode;
  int gait;
  std::int64_t ms;
};

// A sample over all its parts.
TEST(MotionTable, NamesModeGaitAndTimeAsTheBoardDoes) {
  for (const Row& row :
       {Row{0, 0, 0, 1000},        Row{101, 7, 1, 5000},      Row{111, 12, 0, 15000},
        Row{121, 17, 1, 8000},     Row{130, 16, 0, 1500},     Row{131, 16, 3, 1500},
        Row{132, 16, 1, 2500},     Row{136, 16, 6, 1500},     Row{140, 62, 0, 60000},
        Row{146, 62, 6, 15000},    Row{148, 62, 8, 15000},    Row{152, 62, 12, 15000},
        Row{171, 62, 31, 15000},   Row{176, 62, 111, 120000}, Row{180, 11, 80, 15000},
        Row{199, 11, 99, 15000},   Row{201, 3, 0, 0},         Row{212, 21, 0, -1},
        Row{303, 11, 27, 0},       Row{309, 11, 28, 0},       Row{340, 11, 120, -1},
        Row{505, 62, 118, 120000}, Row{507, 17, 8, 1800},     Row{513, 65, 1, 10000}}) {
    const Motion* motion = TheTable().Find(row.id);
    ASSERT_NE(motion, nullptr) << row.id;
    EXPECT_EQ(motion->mode, row.mode) << row.id;
    EXPECT_EQ(motion->gait, row.gait) << row.id;
    EXPECT_EQ(motion->min_exec_time_ms, row.ms) << row.id;
    EXPECT_EQ(TheTable().Find(motion->mode, motion->gait), motion);
  }
}

TEST(MotionTable, ListsTheModesThatMayFollow) {
  EXPECT_THAT(TheTable().Find(101)->next, ElementsAre(0, 12, 7, 80));
  EXPECT_THAT(TheTable().Find(0)->next, ElementsAre(0, 12, 7, 15));
  EXPECT_THAT(TheTable().Find(303)->next, ElementsAre(0, 12, 7, 21, 3, 6, 11, 23, 80, 81, 82));
  EXPECT_TRUE(TheTable().Find(101)->MayGoTo(12));
  EXPECT_FALSE(TheTable().Find(101)->MayGoTo(11));
}

// From every motion the body can be brought to lie and to stand; else no motion could end safely.
TEST(MotionTable, LeadsFromEveryMotionToLyingAndStanding) {
  for (const Motion& motion : TheTable().motions()) {
    EXPECT_TRUE(motion.MayGoTo(7)) << motion.id;
    EXPECT_TRUE(motion.MayGoTo(12)) << motion.id;
    EXPECT_TRUE(motion.MayGoTo(0) || motion.id == 500) << motion.id;
  }
}

TEST(MotionTable, LimitsTheSpeedsOfItsGaits) {
  const std::map<std::int32_t, SpeedLimit> limits = {{303, {0.65F, 0.30F, 1.25F}},
                                                     {308, {1.00F, 0.30F, 1.25F}},
                                                     {305, {1.60F, 0.55F, 2.50F}},
                                                     {302, {0.25F, 0.10F, 0.50F}},
                                                     {301, {0.40F, 0.30F, 0.75F}}};
  for (const auto& [id, limit] : limits) EXPECT_EQ(TheTable().Find(id)->limit, limit) << id;
  for (const Motion& motion : TheTable().motions()) {
    EXPECT_TRUE(motion.servo != "walk" || motion.limit) << motion.id;
  }
}

// The result commands that are permitted at a low battery.
TEST(MotionTable, KeepsTheProtectedMotionsApartFromTheOthers) {
  const std::set<std::string> spared = {"stand", "get_down", "body_pose"};
  std::set<std::int32_t> ids;
  for (const Motion& motion : TheTable().motions()) {
    if (motion.capability.empty() || spared.count(motion.capability) > 0) ids.insert(motion.id);
  }
  EXPECT_THAT(ids, UnorderedElementsAre(0, 101, 102, 111, 212));
}

TEST(MotionTable, GivesTheFlipsACapabilityOfTheirOwn) {
  for (const Motion& motion : TheTable().motions()) {
    EXPECT_EQ(motion.capability == "back_flip", motion.mode == 17) << motion.id;
  }
}

// What is not declared is allowed in Active.
TEST(MotionTable, HasNoFlipJumpDanceOrTrickThatTheConfigOfTheCyberDog2Allows) {
  const musher::ConfigReading robot =
      musher::ReadConfigFile(SourceDir() + "/config/cyberdog2.toml");
  ASSERT_TRUE(robot.config);
  const std::set<std::string> plain = {"",     "get_down",  "stand",     "stand_on_ground",
                                       "pose", "body_pose", "timed_walk"};
  CapabilityView view;
  view.actuator = "motion_manager";
  view.battery = 100;
  for (const Motion& motion : TheTable().motions()) {
    const auto may = [&](const char* state) {
      view.state = state;
      return EvaluateCapability(*robot.config, motion.capability, view).ok();
    };
    EXPECT_EQ(may("Active"), plain.contains(motion.capability)) << motion.id;
    EXPECT_TRUE(!may("Protected") || plain.contains(motion.capability)) << motion.id;
  }
}

// The robot's state config permits in Protected the same as CyberDog's rules: to stand, to lie,
// the plain pose as result commands, and walking by servo.
TEST(MotionTable, AllowsInProtectedTheMotionsForALowBattery) {
  const musher::ConfigReading robot = musher::ReadConfigFile(SourceDir() + "/config/robot.toml");
  ASSERT_TRUE(robot.config);
  CapabilityView view;
  view.actuator = "motion_manager";
  view.state = kProtected;
  view.battery = 50;
  std::set<std::int32_t> results;
  for (const Motion& motion : TheTable().motions()) {
    const auto may = [&](const std::string& capability) {
      return EvaluateCapability(*robot.config, capability, view).ok();
    };
    if (motion.capability.empty() || may(motion.capability)) results.insert(motion.id);
    EXPECT_TRUE(motion.servo.empty() || may(motion.servo)) << "servo " << motion.id;
  }
  EXPECT_THAT(results, UnorderedElementsAre(0, 101, 102, 111, 212));
}

// --- Errors of a file

constexpr const char* kNeeded = R"(motion = [
  { id = 0, name = "ESTOP", mode = 0, gait = 0, min_exec_time_ms = 1000, next = "all" },
  { id = 101, name = "A", mode = 7, gait = 1, min_exec_time_ms = 1, next = "all", capability = "x" },
  { id = 102, name = "B", mode = 7, gait = 0, min_exec_time_ms = 1, next = "all", capability = "x" },
  { id = 111, name = "C", mode = 12, gait = 0, min_exec_time_ms = 1, next = "all", capability = "x" },
  { id = 112, name = "D", mode = 11, gait = 1, min_exec_time_ms = 1, next = "all", capability = "x" },
  { id = 118, name = "E", mode = 80, gait = 1, min_exec_time_ms = 1, next = "all", capability = "x" },
)";

std::vector<std::string> FaultsOf(const std::string& rows) {
  const TableReading reading =
      ReadTableText("group.all = [0, 7, 11, 12]\n" + std::string(kNeeded) + rows + "]\n", "t.toml");
  std::vector<std::string> faults;
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    faults.push_back(FormatDiagnostic(diagnostic));
  }
  EXPECT_EQ(reading.table.has_value(), faults.empty());
  return faults;
}

TEST(MotionTableFile, MayBeAsSmallAsTheManagerNeeds) {
  EXPECT_THAT(FaultsOf(""), IsEmpty());
}

TEST(MotionTableFile, ReportsWhichMotionOfTheManagersOwnIsMissing) {
  const TableReading reading = ReadTableText("motion = []\n", "t.toml");
  ASSERT_EQ(reading.diagnostics.size(), 7U);
  EXPECT_THAT(FormatDiagnostic(reading.diagnostics[1]),
              "t.toml:1:10: error: motion: there is no motion 0, which the motion manager itself "
              "commands");
}

struct BadRow {
  const char* name;
  const char* row;
  const char* fault;
};

class BadTable : public ::testing::TestWithParam<BadRow> {};

TEST_P(BadTable, IsReportedWithItsPlace) {
  EXPECT_THAT(FaultsOf(GetParam().row), ElementsAre(GetParam().fault));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadTable,
    ::testing::Values(
        BadRow{
            "TwiceTheSameId",
            R"({ id = 111, name = "X", mode = 1, gait = 9, min_exec_time_ms = 0, next = [0], capability = "x" })",
            "t.toml:9:8: error: motion: id 111 is already defined in line 6 already"},
        BadRow{
            "TwiceTheSameModeAndGait",
            R"({ id = 5, name = "X", mode = 12, gait = 0, min_exec_time_ms = 0, next = [0], capability = "x" })",
            "t.toml:9:30: error: motion: mode 12 with gait 0 is already defined in line 6 already"},
        BadRow{
            "AnUnknownGroup",
            R"({ id = 5, name = "X", mode = 1, gait = 0, min_exec_time_ms = 0, next = "al", capability = "x" })",
            "t.toml:9:72: error: motion.next: there is no group \"al\"; did you mean \"all\"?"},
        BadRow{
            "AModeOutOfRange",
            R"({ id = 5, name = "X", mode = 1, gait = 0, min_exec_time_ms = 0, next = [0, 128], capability = "x" })",
            "t.toml:9:76: error: motion.next: expected a mode from 0 to 127, found 128"},
        BadRow{"NoCapability",
               R"({ id = 5, name = "X", mode = 1, gait = 0, min_exec_time_ms = 0, next = [0] })",
               "t.toml:9:1: error: motion.capability: is missing; only emergency stop is never "
               "refused"},
        BadRow{
            "AMisspeltKey",
            R"({ id = 5, name = "X", mode = 1, gait = 0, min_exec_time_ms = 0, next = [0], capability = "x", serwo = "walk" })",
            "t.toml:9:95: error: motion: unknown key \"serwo\"; did you mean \"servo\"?"}),
    [](const auto& param) { return param.param.name; });

TEST(MotionConfigFile, OfTheProductHasTheDefaults) {
  const auto reading = ReadMotionConfigFile(SourceDir() + "/config/motion/motion_manager.toml");
  ASSERT_TRUE(reading.config);
  MotionConfig defaults;
  defaults.motions = SourceDir() + "/config/motion/motions.toml";
  defaults.gaits = SourceDir() + "/config/motion/gaits";
  EXPECT_EQ(*reading.config, defaults);
}

TEST(MotionConfigFile, TakesAllItsKeys) {
  const auto reading = ReadMotionConfigText(
      "motions = \"/t.toml\"\n[priority]\nalgo = -3\n[board]\nwait_ms = 1\n"
      "silent_ms = 2\nfeedback_ms = 3\n",
      "/a/m.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->motions, "/t.toml");
  EXPECT_EQ(reading.config->priorities.at(kFromAlgorithm), -3);
  EXPECT_EQ(reading.config->board_wait, Milliseconds(1));
  EXPECT_EQ(reading.config->board_silent, Milliseconds(2));
  EXPECT_EQ(reading.config->board_feedback, Milliseconds(3));
}

TEST(MotionConfigFile, TakesTheKeysOfABoardOnLcm) {
  const auto reading = ReadMotionConfigText(
      "[board]\nkind = \"lcm\"\ncommand_url = \"udpm://239.1.2.3:1\"\n"
      "response_url = \"udpm://239.1.2.3:2?ttl=0\"\nlocalization_url = \"udpm://239.1.2.3:3\"\n"
      "interface = \"eth0\"\nttl = 255\nboard = \"192.168.44.233\"\n",
      "m.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->board, BoardKind::kLcm);
  EXPECT_EQ(reading.config->lcm, (LcmConfig{"udpm://239.1.2.3:1", "udpm://239.1.2.3:2?ttl=0",
                                            "udpm://239.1.2.3:3", "eth0", 255, "192.168.44.233"}));
}

TEST(MotionConfigFile, TakesTheFramesAndTheirMounts) {
  const auto reading = ReadMotionConfigText(
      "[tf]\npublish = true\nodom = \"dog1/odom\"\nbase = \"dog1/base_link\"\n"
      "[[tf.mount]]\nframe = \"dog1/laser\"\nxyz_m = [0.1, 0, 0.2]\nrpy_deg = [0, 0, 180]\n"
      "[[tf.mount]]\nframe = \"dog1/beam\"\nparent = \"dog1/laser\"\n",
      "m.toml");
  ASSERT_TRUE(reading.config);
  const TfConfig& tf = reading.config->tf;
  EXPECT_TRUE(tf.publish);
  EXPECT_EQ(tf.odom, "dog1/odom");
  ASSERT_EQ(tf.mounts.size(), 2U);
  EXPECT_EQ(tf.mounts[0],
            (Mount{"dog1/laser", "dog1/base_link", {0.1, 0, 0.2}, {0, 0, std::numbers::pi}}));
  EXPECT_EQ(tf.mounts[1].parent, "dog1/laser");
}

TEST(MotionConfigFile, RefusesAFrameWithTwoPlacesOrNone) {
  const auto reading = ReadMotionConfigText(
      "[tf]\nbase = \"odom\"\n"
      "[[tf.mount]]\nxyz_m = [1, 2]\n"
      "[[tf.mount]]\nframe = \"laser\"\n"
      "[[tf.mount]]\nframe = \"laser\"\n"
      "[[tf.mount]]\nframe = \"odom\"\n",
      "m.toml");
  EXPECT_FALSE(reading.config);
  std::vector<int> lines;
  for (const Diagnostic& diagnostic : reading.diagnostics) lines.push_back(diagnostic.line);
  EXPECT_THAT(lines, ElementsAre(2, 3, 4, 8, 10));
}

// tf2 has no place for any of them. The order of the mounts is free.
TEST(MotionConfigFile, RefusesAMountThatClosesACycleOfFrames) {
  const std::string chain =
      "[tf]\n[[tf.mount]]\nframe = \"finger\"\nparent = \"hand\"\n"
      "[[tf.mount]]\nframe = \"hand\"\nparent = \"arm\"\n";
  EXPECT_TRUE(ReadMotionConfigText(chain + "[[tf.mount]]\nframe = \"arm\"\n", "m.toml").config);
  const auto reading =
      ReadMotionConfigText(chain +
                               "[[tf.mount]]\nframe = \"arm\"\nparent = \"finger\"\n"
                               "[[tf.mount]]\nframe = \"laser\"\nparent = \"hand\"\n",
                           "m.toml");
  EXPECT_FALSE(reading.config);
  ASSERT_EQ(reading.diagnostics.size(), 1U);
  EXPECT_EQ(reading.diagnostics[0].line, 10);
  EXPECT_THAT(reading.diagnostics[0].message,
              ::testing::HasSubstr("parent: 'finger' is fixed on 'arm': a cycle of frames"));
}

TEST(MotionConfigFile, OfTheCyberDog2TakesItsBoardOnly) {
  const auto reading = ReadMotionConfigFile(SourceDir() + "/config/motion/cyberdog2.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->lcm.board, "192.168.44.233");
  EXPECT_TRUE(reading.config->tf.publish);
}

TEST(MotionConfigFile, WarnsOfTheTopicClockWhereARobotMayBe) {
  MotionConfig config;
  EXPECT_FALSE(WarningOfClock(config, ClockSource::kTopic)) << "a simulated body";
  config.board = BoardKind::kLcm;
  EXPECT_TRUE(WarningOfClock(config, ClockSource::kTopic));
  EXPECT_FALSE(WarningOfClock(config, ClockSource::kSteady));
  config.lcm.ttl = 0;
  EXPECT_FALSE(WarningOfClock(config, ClockSource::kTopic));
  config.lcm.ttl = 1;
  config.lcm.network_interface = "lo";
  EXPECT_FALSE(WarningOfClock(config, ClockSource::kTopic));
}

TEST(MotionConfigFile, RefusesAWrongKindUrlAndAddressWithItsPlace) {
  const auto reading = ReadMotionConfigText(
      "[board]\nkind = \"lmc\"\ncommand_url = \"udpm://192.168.44.233:7671\"\nttl = 256\n"
      "board = \"192.168.44\"\n",
      "m.toml");
  EXPECT_FALSE(reading.config);
  std::vector<int> lines;
  for (const Diagnostic& diagnostic : reading.diagnostics) lines.push_back(diagnostic.line);
  EXPECT_THAT(lines, ElementsAre(2, 3, 4, 5));
}

TEST(MotionConfigFile, IsReportedWithErrorAndPlace) {
  const auto reading = ReadMotionConfigText(
      "clock = \"topic\"\nboard.wait_ms = 0\n[priority]\nap = 1\nvis = 101\n", "m.toml");
  EXPECT_FALSE(reading.config);
  std::vector<int> lines;
  for (const Diagnostic& diagnostic : reading.diagnostics) lines.push_back(diagnostic.line);
  EXPECT_THAT(lines, ElementsAre(1, 2, 4, 5));
  EXPECT_FALSE(ReadMotionConfigText("motions = ", "m.toml").config);
  EXPECT_FALSE(ReadMotionConfigFile("/absent.toml").config);
  EXPECT_FALSE(ReadTableFile("/").table);
}

}  // namespace musher::motion::testing::motion_table_test
