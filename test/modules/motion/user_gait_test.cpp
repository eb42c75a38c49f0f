// Gaits of users as the texts that a motion board takes, and what is refused.

#include "musher/modules/motion/user_gait.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <ostream>

#include "musher/base/files.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::motion::testing::user_gait_test {

using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kSections = "[[section]]\ncontact = [1, 0, 0, 1]\nduration = 12\n";

std::string Step(const std::string& key = "", const std::string& value = "") {
  std::string text = "[[step]]\n";
  for (const auto& [name, usual] : std::vector<std::pair<std::string, std::string>>{
           {"type", "\"usergait\""},
           {"body_vel_des", "[0.1, 0.0, 0.2]"},
           {"body_pos_des", "[0.01, 0.02, 0.03, 0.04, 0.05, 0.06]"},
           {"landing_pos_des", "[0.1, 0.2, 0.9, 0.3, 0.4, 0.9, 0.5, 0.6, 0.9, 0.7, 0.8, 0.9]"},
           {"step_height", "[0.03, 0.05, 0.0, 0.08]"},
           {"weight", "[10.0, 20.0, 30.0, 40.0, 50.0, 60.0]"},
           {"use_mpc_traj", "1"},
           {"mu", "0.4"},
           {"landing_gain", "1.55"},
           {"gait_id", "110"},
           {"duration", "300"}}) {
    if (name != key || !value.empty()) text += name + " = " + (name == key ? value : usual) + "\n";
  }
  return text;
}

TEST(UserGait, BecomesTheFieldsOfCommands) {
  const auto gait = ReadUserGait("# any comment\n" + kSections, Step());
  ASSERT_TRUE(gait) << gait.error().message;
  EXPECT_EQ(gait.value().sections, "# Gait Def\n" + kSections);
  EXPECT_EQ(gait.value().steps,
            "# Gait Params\n[[step]]\nmode = 11\ngait_id = 110\ncontact = 15\nlife_count = 0\n"
            "vel_des = [0.1, 0.0, 0.2]\nrpy_des = [0.01, 0.02, 0.03]\n"
            "pos_des = [0.04, 0.05, 0.06]\nacc_des = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]\n"
            "ctrl_point = [0.7, 0.8, 0.4]\nfoot_pose = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]\n"
            "step_height = [50030.0, 80000.0]\nvalue = 1\nduration = 300\n");
  EXPECT_EQ(gait.value().duration_ms, 300);
}

TEST(UserGait, IsTheSameByFeetAndPaces) {
  msg::MotionSequenceShow::Request sequence;
  sequence.gait_list = {{true, false, false, true, 12}};
  msg::MotionSequencePace pace;
  pace.twist.linear.x = 0.1;
  pace.twist.angular.z = 0.2;
  pace.centroid.position = {0.04, 0.05, 0.06};
  pace.weight = {{10, 20, 30}, {40, 50, 60}};
  pace.right_forefoot = {0.1, 0.2, 0.9, 0.03F};
  pace.left_forefoot = {0.3, 0.4, 0.9, 0.05F};
  pace.right_hindfoot = {0.5, 0.6, 0.9, 0};
  pace.left_hindfoot = {0.7, 0.8, 0.9, 0.08};
  pace.friction_coefficient = 0.4F;
  pace.landing_gain = 1.55F;
  pace.use_mpc_track = true;
  pace.duration = 300;
  sequence.pace_list = {pace};
  ASSERT_TRUE(HasUserGait(sequence));
  const auto by_lists = UserGaitOf(sequence);
  ASSERT_TRUE(by_lists) << by_lists.error().message;
  const auto by_toml =
      ReadUserGait(kSections, Step("body_pos_des", "[0.0, 0.0, 0.0, 0.04, 0.05, 0.06]"));
  EXPECT_EQ(by_lists.value(), by_toml.value());
  msg::MotionSequenceShow::Request texts;
  texts.gait_toml = kSections;
  texts.pace_toml_list = {Step(), Step()};
  EXPECT_EQ(UserGaitOf(texts).value().duration_ms, 600);
}

// The table reduces the speed of a walk, and a gait had its own.
TEST(UserGait, IsNoFasterAndNoLongerThanItsMotion) {
  Motion motion;
  motion.id = 401;
  motion.limit = {0.65F, 0.30F, 1.25F};
  const auto slow = ReadUserGait(kSections, Step());
  EXPECT_TRUE(CheckGait(motion, slow.value()));
  const auto aside = ReadUserGait(kSections, Step("body_vel_des", "[0.2, -0.5, 0.0]"));
  ASSERT_TRUE(aside);
  EXPECT_THAT(CheckGait(motion, aside.value()).error().message,
              HasSubstr("its speed in y is up to 0.5; motion 401 may have 0.3"));
  motion.limit.reset();
  EXPECT_FALSE(CheckGait(motion, aside.value())) << "the limit of sequences";
  motion.min_exec_time_ms = 250;
  EXPECT_THAT(CheckGait(motion, slow.value()).error().message, HasSubstr("its steps take 300 ms"));
}

TEST(UserGait, TurnsItsBodyEitherWay) {
  msg::MotionSequenceShow::Request sequence;
  sequence.gait_list = {{true, false, false, true, 12}};
  msg::MotionSequencePace pace;
  pace.centroid.orientation = {0, 0, std::sin(-0.05), std::cos(-0.05)};
  pace.right_forefoot = {0, 0, 0, 0.03F};
  pace.duration = 300;
  sequence.pace_list = {pace};
  const auto gait = UserGaitOf(sequence);
  ASSERT_TRUE(gait) << gait.error().message;
  EXPECT_THAT(gait.value().steps, HasSubstr("rpy_des = [0.0, 0.0, -0.1]"));
}

// Its w is 0, as in the programs that have roll, pitch and yaw there.
TEST(UserGait, ThatTurnsItsBodyUpsideDownOrBackIsRefused) {
  msg::MotionSequenceShow::Request sequence;
  sequence.gait_list = {{true, false, false, true, 12}};
  msg::MotionSequencePace pace;
  pace.right_forefoot = {0, 0, 0, 0.03F};
  pace.duration = 300;
  for (const msg::Quaternion& half_turn :
       {msg::Quaternion{0, 0, 1, 0}, msg::Quaternion{0, -1, 0, 0}, msg::Quaternion{0.6, 0.8, 0, 0},
        msg::Quaternion{0.707, 0.707, 0, 0}}) {
    pace.centroid.orientation = half_turn;
    sequence.pace_list = {pace};
    const auto gait = UserGaitOf(sequence);
    ASSERT_FALSE(gait);
    EXPECT_EQ(gait.error().code, 3031);
    EXPECT_THAT(gait.error().message, HasSubstr("the pose of the body"));
  }
}

TEST(UserGait, OfThisTreeIsValid) {
  const std::string begin = SourceDir() + "/config/motion/gaits/400.";
  const auto gait = ReadUserGait(ReadFile(begin + "sections.toml"), ReadFile(begin + "steps.toml"));
  ASSERT_TRUE(gait) << gait.error().message;
  EXPECT_THAT(gait.value().sections, StartsWith("# Gait Def\n[[section]]\ncontact = [1, 1, 1, 1]"));
}

struct BadGait {
  std::string name;
  std::string sections;
  std::string steps;
  std::int32_t code;
  std::string message;

  friend void PrintTo(const BadGait& bad, std::ostream* out) { *out << bad.name; }
};

class BadUserGait : public ::testing::TestWithParam<BadGait> {};

TEST_P(BadUserGait, IsRefusedWithACodeAndTheReason) {
  const auto gait = ReadUserGait(GetParam().sections, GetParam().steps);
  ASSERT_FALSE(gait);
  EXPECT_EQ(gait.error().code, GetParam().code);
  EXPECT_THAT(gait.error().message, HasSubstr(GetParam().message));
}

std::string Times(int count, const std::string& text) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

INSTANTIATE_TEST_SUITE_P(
    Gaits, BadUserGait,
    ::testing::Values(
        BadGait{"Of1Megabyte", std::string(1'000'000, '#'), Step(), 3010,
                "the sections of the gait have 1000000 bytes; a motion board takes at most 60000"},
        BadGait{"WithStepsOf1Megabyte", kSections, std::string(1'000'000, '#'), 3010,
                "the steps of the gait have 1000000 bytes"},
        BadGait{"ThatIsLongerForTheBoard", kSections, Times(180, Step()), 3010, "at most 60000"},
        BadGait{"WithoutFeet", "", Step(), 3031, "no sections that say which feet stand"},
        BadGait{"WithoutSteps", kSections, "", 3031, "no steps of the body"},
        BadGait{"ThatIsNoToml", "[[section", Step(), 3031, "section:1:"},
        BadGait{"WithThreeFeet", "[[section]]\ncontact = [1, 1, 1]\nduration = 1\n", Step(), 3031,
                "section:2:"},
        BadGait{"WithAHalfContact", "[[section]]\ncontact = [1, 1, 1, 2]\nduration = 1\n", Step(),
                3031, "section:2:"},
        BadGait{"WithoutDuration", "[[section]]\ncontact = [1, 1, 1, 1]\n", Step(), 3031,
                "duration"},
        BadGait{"WithAnUnknownKey", "[[section]]\ncontakt = [1, 1, 1, 1]\nduration = 1\n", Step(),
                3031, "contact"},
        BadGait{"OfAnotherType", kSections, Step("type", "\"jump\""), 3031, "usergait"},
        BadGait{"OfAnotherGait", kSections, Step("gait_id", "27"), 3031, "gait_id"},
        BadGait{"WithAMissingWeight", kSections, Step("weight"), 3031, "weight"},
        BadGait{"WithTooFewHeights", kSections, Step("step_height", "[0.03]"), 3031, "step_height"},
        BadGait{"WithANumberThatIsNone", kSections, Step("body_vel_des", "[nan, 0.0, 0.0]"), 3031,
                "body_vel_des"},
        BadGait{"ThatIsTooFast", kSections, Step("body_vel_des", "[1.7, 0.0, 0.0]"), 3031,
                "step 1: its speed in x and y must be finite and at most 1.6"},
        BadGait{"ThatStepsTooHigh", kSections, Step("step_height", "[0.09, 0.0, 0.0, 0.0]"), 3031,
                "the height of a step must be 0 to 0.08 m"},
        BadGait{"WithAGainThatIsNoInt8", kSections, Step("landing_gain", "13.0"), 3031,
                "landing gain"},
        BadGait{"ThatTakesNoTime", kSections, Step("duration", "0"), 3031, "duration"}),
    [](const auto& bad) { return bad.param.name; });

TEST(BadSequence, WithNumbersThatAreNoneIsRefused) {
  msg::MotionSequenceShow::Request sequence;
  sequence.gait_list = {{true, true, true, true, 12}};
  sequence.pace_list.emplace_back();
  sequence.pace_list[0].duration = 100;
  sequence.pace_list[0].centroid.position.z = NAN;
  const auto gait = UserGaitOf(sequence);
  ASSERT_FALSE(gait);
  EXPECT_EQ(gait.error().code, 3031);
  EXPECT_THAT(gait.error().message, HasSubstr("step 1: the pose of the body must be finite"));
  sequence.pace_list[0].centroid.position.z = 0;
  sequence.pace_list[0].centroid.orientation = {NAN, 0, 0, 1};
  EXPECT_EQ(UserGaitOf(sequence).error().code, 3031);
}

// CyberDog's own programs give the same gait four times: as lists, as one text and as a text of
// each. The steps of their texts have the fields of commands.
TEST(Sequence, OfCyberDogsOwnProgramsIsTaken) {
  const std::string section =
      "# Gait toml meta.\n\n# 1/1\n[[section]]\ncontact  = [1, 0, 0, 1]\nduration = 12\n\n";
  const std::string step =
      "# Pace toml meta.\n\n# 1/1\n[[step]]\nmode = 11\ngait_id = 110\ncontact = 15\n"
      "life_count = 0\nvel_des = [0.100000, 0.000000, 0.200000]\n"
      "rpy_des = [0.010000, 0.020000, 0.030000]\npos_des = [0.040000, 0.050000, 0.060000]\n"
      "acc_des = [10.000000, 20.000000, 30.000000, 40.000000, 50.000000, 60.000000]\n"
      "ctrl_point = [0.700000, 0.800000, 0.400000]\n"
      "foot_pose = [0.100000, 0.200000, 0.300000, 0.400000, 0.500000, 0.600000]\n"
      "step_height = [50030.000000, 80000.000000]\nvalue = 1\nduration = 300\n\n";
  msg::MotionSequenceShow::Request sequence;
  sequence.motion_id = 400;
  sequence.duration = 300;
  sequence.gait_list = {{true, false, false, true, 12}};
  msg::MotionSequencePace pace;
  pace.twist.linear = {0.1, 0, 0.2};
  pace.centroid.orientation = {0.01, 0.02, 0.03, 1};
  pace.centroid.position = {0.04, 0.05, 0.06};
  pace.weight = {{10, 20, 30}, {40, 50, 60}};
  pace.right_forefoot = {0.1, 0.2, 0, 0.03F};
  pace.left_forefoot = {0.3, 0.4, 0, 0.05F};
  pace.right_hindfoot = {0.5, 0.6, 0, 0};
  pace.left_hindfoot = {0.7, 0.8, 0, 0.08};
  pace.friction_coefficient = 0.4F;
  pace.landing_gain = 1.55F;
  pace.use_mpc_track = true;
  pace.duration = 300;
  sequence.pace_list = {pace};
  const auto by_lists = UserGaitOf(sequence);
  ASSERT_TRUE(by_lists) << by_lists.error().message;
  EXPECT_EQ(by_lists.value(), ReadUserGait(kSections, Step()).value())
      << "its yaw rate is linear z, and its rotation roll, pitch and yaw";
  sequence.gait_toml = "# Gait Def (Gait toml).\n" + section;
  sequence.pace_toml = "# Gait Params (Pace toml).\n" + step;
  sequence.gait_toml_list = {section};
  sequence.pace_toml_list = {step};
  const auto by_texts = UserGaitOf(sequence);
  ASSERT_TRUE(by_texts) << by_texts.error().message;
  EXPECT_EQ(by_texts.value().sections, by_lists.value().sections) << "once";
  EXPECT_EQ(by_texts.value(), by_lists.value());
}

TEST(Sequence, WithFurtherTextsHasAllOfThem) {
  msg::MotionSequenceShow::Request sequence;
  sequence.gait_toml = kSections;
  sequence.gait_toml_list = {"[[section]]\ncontact = [1, 1, 1, 1]\nduration = 3\n"};
  sequence.pace_toml = Step();
  sequence.pace_toml_list = {Step("duration", "200"), Step("duration", "100")};
  const auto gait = UserGaitOf(sequence);
  ASSERT_TRUE(gait) << gait.error().message;
  EXPECT_EQ(gait.value().duration_ms, 600);
  EXPECT_THAT(gait.value().sections, HasSubstr("contact = [1, 1, 1, 1]\nduration = 3\n"));
}

// The loop would write a text of 50 MB, while the board gets no frame for longer than 500 ms.
TEST(BadSequence, OfAMillionSectionsIsRefusedBeforeItsTextIsWritten) {
  constexpr std::size_t kMany = 1'000'000;
  msg::MotionSequenceShow::Request sequence;
  sequence.gait_list.assign(kMany, {true, false, false, true, 12});
  sequence.pace_list.emplace_back();
  sequence.pace_list[0].duration = 300;
  const auto sections = UserGaitOf(sequence);
  ASSERT_FALSE(sections);
  EXPECT_EQ(sections.error().code, 3010);
  EXPECT_THAT(sections.error().message, HasSubstr("1000000 sections, and at most 1"));
  sequence.gait_list.resize(1);
  sequence.pace_list.resize(1000, sequence.pace_list[0]);
  EXPECT_THAT(UserGaitOf(sequence).error().message, HasSubstr("1000 steps, and at most "));
}

TEST(BadSequence, OfCommandsThatAreNoGaitIsRefused) {
  for (const std::string wrong :
       {"mode = 12\ngait_id = 110", "mode = 11\ngait_id = 27", "mode = 11\ngait_id = 110"}) {
    msg::MotionSequenceShow::Request sequence;
    sequence.gait_toml = kSections;
    sequence.pace_toml = "[[step]]\n" + wrong + "\nduration = 300\n";
    EXPECT_EQ(UserGaitOf(sequence).error().code, 3031) << wrong;
  }
}

}  // namespace musher::motion::testing::user_gait_test
