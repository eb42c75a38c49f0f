// What comes wrong from outside to a skill that moves the robot: its run has a definite end, at a
// stand, with its reason in a sentence.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::skill_bad_input_test {

using skill::Status;
using skills::testing::SkillsOnARobot;

using Texts = std::vector<std::pair<std::string, std::string>>;

struct Wanted {
  std::string skill;
  Texts parameters;
};

// A wall 3 m ahead, so that a robot that looks is held there.
class ASkill : public ::testing::Test {
 protected:
  static void Prepare(SkillsOnARobot& skills) {
    for (int i = -40; i <= 40; ++i) skills.robot.points.push_back({3, 0.1 * i, 0});
    skills.robot.blocked = [](const navigation::Point& at) { return at.x_m > 2.7; };
    skills.robot.look = [&skills](const std::string&, Time time) {  // a dock
      const navigation::Pose& at = skills.robot.at;
      const double x = 2 - at.at.x_m, y = 2 - at.at.y_m;
      const double c = std::cos(at.yaw_rad), s = std::sin(at.yaw_rad);
      return std::optional(skills::Look{time, {{c * x + s * y, c * y - s * x, 0}}});
    };
  }
  // Within 12 minutes, which is more than the limit of a run.
  static void ExpectDefiniteEnd(SkillsOnARobot& skills, const Wanted& wanted) {
    const Result<> started = skills.Start(wanted.skill, wanted.parameters);
    std::string what = wanted.skill;
    for (const auto& [key, value] : wanted.parameters) what += " " + key + "=" + value;
    if (!started) {
      EXPECT_LT(started.error().message.size(), 300U) << what;
      return;
    }
    EXPECT_TRUE(skills.RunToItsEnd(720)) << what << ": " << skills.message();
    EXPECT_FALSE(skills.message().empty()) << what;
    EXPECT_LT(skills.message().size(), 300U) << what << ": " << skills.message();
    for (int i = 0; i < 20; ++i) skills.robot.Advance(Milliseconds(100));
    EXPECT_TRUE(skills.robot.Rests()) << what << ": " << skills.message();
  }
};

TEST_F(ASkill, EndsWithASentenceForNumbersThatAreHugeOrNone) {
  for (const std::string number : {"1e308", "-1e308", "1e999", "nan", "inf"}) {
    const std::string place = "[" + number + ", " + number + ", 0]";
    for (const Wanted& wanted : std::vector<Wanted>{
             {"navigate_to", {{"goal_pos", place}}},
             {"navigate_to", {{"goal_pos", "[2, 0, 0]"}, {"start_pos", place}}},
             {"navigate_to",
              {{"goal_pos", "[2, 0]"}, {"goal_quat_wxyz", "[" + number + ", 0, 0, 0]"}}},
             {"nav_2d", {{"goal_pos", "[2, 0, 0]"}, {"ground_height", number}}},
             {"move", {{"path", "[[1, 0], " + place + "]"}, {"loops", "1"}}},
             {"explore", {{"boundary", "[[0, 0], [2, 0], " + place + "]"}}},
             {"explore", {{"boundary", "[[0, 0], [2, 0], [2, 2]]"}, {"lane_width", number}}},
             {"track", {{"target_topic", "/t"}, {"distance", number}, {"duration", "5"}}},
             {"follow_line", {{"speed", number}}},
             {"avoid_obstacle", {{"goal_pos", place}}},
             {"avoid_obstacle", {{"heading", number}, {"distance", "1"}}},
             {"avoid_obstacle", {{"distance", number}}},
             {"visual_servoing", {{"target", "dock"}, {"distance", number}}},
             {"visual_servoing", {{"target", "dock"}, {"bearing", number}}},
             {"visual_servoing", {{"target", "dock"}, {"tolerance", number}}},
             {"visual_servoing", {{"target", "dock"}, {"speed", number}}},
         }) {
      SkillsOnARobot skills;
      Prepare(skills);
      ExpectDefiniteEnd(skills, wanted);
    }
  }
}

TEST_F(ASkill, PlansFromAStartFarAwayAndDoesNotDriveThere) {
  SkillsOnARobot skills;
  skills.robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return navigation::MakeError(navigation::Fault::kOutside, "the start is outside the map");
  };
  ExpectDefiniteEnd(skills,
                    {"navigate_to", {{"goal_pos", "[2, 0]"}, {"start_pos", "[1e6, 0, 0]"}}});
  EXPECT_EQ(skills.message(), "Planning failed: the start is outside the map");
  EXPECT_EQ(skills.robot.travelled_m, 0);
}

struct BadSource {
  const char* name;
  std::function<void(SkillsOnARobot&)> happens;  // each step from the fifth second on
};

void PrintTo(const BadSource& source, std::ostream* out) {
  *out << source.name;
}

class ASkillWithABadSource : public ASkill, public ::testing::WithParamInterface<BadSource> {};

TEST_P(ASkillWithABadSource, HasADefiniteEndAtAStandWithItsReason) {
  for (const Wanted& wanted : std::vector<Wanted>{
           {"navigate_to", {{"goal_pos", "[2, 4, 0]"}}},
           {"explore", {{"boundary", "[[0, 0], [2, 0], [2, 6], [0, 6]]"}}},
           {"avoid_obstacle", {{"goal_pos", "[2, 4]"}}},
           {"visual_servoing", {{"target", "dock"}}},
           {"back_up", {}},
           {"spin", {}},
       }) {
    SkillsOnARobot skills;
    Prepare(skills);
    int steps = 0;
    skills.EachStep([&] {
      if (++steps > 15) GetParam().happens(skills);
    });
    ExpectDefiniteEnd(skills, wanted);
  }
}

const BadSource kSources[] = {
    {"OdometryThatIsLost", [](SkillsOnARobot& s) { s.robot.odometry_up = false; }},
    {"OdometryOfNotANumber", [](SkillsOnARobot& s) { s.robot.at.at.y_m = NAN; }},
    {"OdometryOfHugeNumbers", [](SkillsOnARobot& s) { s.robot.at.at.y_m = 1e308; }},
    {"OdometryThatJumpsToAndFro",
     [](SkillsOnARobot& s) { s.robot.at.at.x_m = s.robot.at.at.x_m > 0 ? -1 : 1; }},
    {"ScanThatIsLost", [](SkillsOnARobot& s) { s.robot.scan_up = false; }},
    {"ScanOfNotANumber",
     [](SkillsOnARobot& s) {
       s.robot.points.assign(9, {NAN, NAN, 0});
     }},
    {"ScanOfPointsInTheRobot", [](SkillsOnARobot& s) { s.robot.points.assign(9, s.robot.at.at); }},
    {"DetectorsThatAreLost",
     [](SkillsOnARobot& s) { s.robot.look = [](const auto&, Time) { return std::nullopt; }; }},
    {"DetectorsThatSeeNoNumbers",
     [](SkillsOnARobot& s) {
       s.robot.look = [](const auto&, Time time) {
         return std::optional(skills::Look{time, {{NAN, INFINITY, 0}}});
       };
     }},
    {"DetectorsThatSeeHugeNumbers",
     [](SkillsOnARobot& s) {
       s.robot.look = [](const auto&, Time time) {
         return std::optional(skills::Look{time, {{1e308, -1e308, 0}}});
       };
     }},
    {"DetectorsThatStand",
     [](SkillsOnARobot& s) {
       s.robot.look = [](const auto&, Time) {
         return std::optional(skills::Look{Time{}, {{1, 1, 0}}});
       };
     }},
    {"PlannerThatIsLost", [](SkillsOnARobot& s) { s.robot.KillPlanner(); }},
    {"ControllerThatIsLost", [](SkillsOnARobot& s) { s.robot.KillController(); }},
    {"PlannerThatDoesNotAnswer", [](SkillsOnARobot& s) { s.robot.answers = false; }},
};

INSTANTIATE_TEST_SUITE_P(Skills, ASkillWithABadSource, ::testing::ValuesIn(kSources),
                         [](const auto& one) { return std::string(one.param.name); });

// The manager's clock runs at a tenth, at ten times, backwards, or stands, beside the robot's.
TEST_F(ASkill, HasADefiniteEndByAClockThatIsWrong) {
  for (const Wanted& wanted : std::vector<Wanted>{{"navigate_to", {{"goal_pos", "[2, 4, 0]"}}},
                                                  {"visual_servoing", {{"target", "dock"}}}}) {
    for (const double rate : {0.1, 10.0, -1.0, 0.0}) {
      SkillsOnARobot skills;
      Prepare(skills);
      ASSERT_TRUE(skills.Start(wanted.skill, wanted.parameters));
      Time shown = Time{} + std::chrono::hours(1);
      for (int i = 0; i < 1200 && skills.run().running(); ++i) {
        skills.robot.Advance(Milliseconds(100));
        shown += FromSeconds(0.1 * rate);
        skills.manager->RunOnce(shown);
      }
      const std::string what = wanted.skill + " at " + std::to_string(rate);
      EXPECT_TRUE(skills.run().ended()) << what << ": " << skills.message();
      for (int i = 0; i < 10; ++i) skills.robot.Advance(Milliseconds(100));
      EXPECT_TRUE(skills.robot.Rests()) << what;
    }
  }
}

}  // namespace musher::skill_bad_input_test
