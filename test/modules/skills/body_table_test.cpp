// The declarations of the skills of the body, the hand and the camera.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/skill/check.hpp"
#include "musher/modules/skills/skills/body_skills.hpp"
#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::body_table_test {

using testing::Bench;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(BodySkills, AreOfferedByTheirNames) {
  Bench bench("jetbot_0", "jetbot");
  EXPECT_THAT(bench.manager().Names(),
              ElementsAre("take_off", "hover", "land", "take_photo", "object_detection", "detect",
                          "pick_up", "put_down", "grasp", "place", "assembly"));
}

TEST(BodySkills, HaveTablesWithoutErrorsAndWarnings) {
  Bench bench("jetbot_0", "jetbot");
  for (const skill::Entry& entry : bench.entries()) {
    const skill::Run run(entry.name, entry.make());
    EXPECT_TRUE(run.built()) << run.built().error().message;
    for (const skill::Problem& problem : skill::Check(run.table())) {
      ADD_FAILURE() << entry.name << ": " << problem.where << ": " << problem.what;
    }
  }
}

TEST(BodySkills, SayWhatTheyDoAndExplainEveryParameter) {
  Bench bench("jetbot_0", "jetbot");
  for (const skill::Entry& entry : bench.entries()) {
    const skill::Run run(entry.name, entry.make());
    EXPECT_NE(run.table().summary(), "") << entry.name;
    for (const auto& parameter : run.table().parameters()) {
      EXPECT_NE(parameter.meaning, "") << entry.name << " " << parameter.name;
    }
  }
}

TEST(BodySkills, UseThePartsOfTheRobotThatTheyMove) {
  Bench bench("jetbot_0", "jetbot");
  std::map<std::string, std::vector<std::string>> parts;
  for (const skill::Entry& entry : bench.entries()) {
    parts[entry.name] = skill::Run(entry.name, entry.make()).table().parts();
  }
  for (const char* flight : {"take_off", "hover", "land"}) {
    EXPECT_THAT(parts[flight], ElementsAre("base")) << flight;
  }
  for (const char* near : {"grasp", "place", "assembly"}) {
    EXPECT_THAT(parts[near], ElementsAre("base", "arm")) << near;
  }
  for (const char* still : {"pick_up", "put_down"}) {
    EXPECT_THAT(parts[still], ElementsAre("arm")) << still;
  }
  EXPECT_THAT(parts["take_photo"], ElementsAre("camera"));
  EXPECT_THAT(parts["object_detection"], ElementsAre("camera"));
  EXPECT_THAT(parts["detect"], ElementsAre());
}

TEST(BodySkills, AreNotRegisteredTwice) {
  testing::FakeRobot robot("jetbot_0", "jetbot");
  skill::Registry registry;
  ASSERT_TRUE(RegisterBodySkills(registry, robot).ok());
  const Result<> again = RegisterBodySkills(registry, robot);
  ASSERT_FALSE(again.ok());
  EXPECT_THAT(again.error().message, HasSubstr("take_off is registered already"));
}

// A number that is infinite or not a number is refused before a skill begins.
TEST(BodySkills, RefuseNumbersThatAreNotFinite) {
  Bench bench("cf2x_0", "cf2x");
  int numbers = 0;
  for (const skill::Entry& entry : bench.entries()) {
    const skill::Run run(entry.name, entry.make());
    for (const auto& parameter : run.table().parameters()) {
      if (parameter.kind != skill::Kind::kNumber) continue;
      ++numbers;
      for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        const Result<> started = bench.manager().Start(entry.name, {{parameter.name, value}});
        ASSERT_FALSE(started.ok());
        EXPECT_THAT(started.error().message, HasSubstr("parameter " + parameter.name));
      }
    }
  }
  EXPECT_GT(numbers, 8);
}

}  // namespace musher::skills::body_table_test
