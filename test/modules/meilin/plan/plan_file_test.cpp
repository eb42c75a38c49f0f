// Plans that a person writes: what is derived, and where errors are.

#include "musher/modules/meilin/plan/plan_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::meilin::plan_file_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* kPlan = R"(side = "blue"
start = [0, 1]

[[step]]
move = [0, 1]
[[step]]
fetch = [1, 1]
[[step]]
move = [1, 1]
[[step]]
fetch = [1, 0]
[[step]]
move = [2, 1]
)";

std::vector<std::string> Errors(const std::string& text) {
  std::vector<std::string> errors;
  for (const Diagnostic& diagnostic : ReadPlanText(text, "plan.toml").diagnostics) {
    errors.push_back(FormatDiagnostic(diagnostic));
  }
  return errors;
}

TEST(DrawnPlan, DerivesHeightsAndYaws) {
  const DrawnPlanReading reading = ReadPlanText(kPlan, "plan.toml");
  ASSERT_TRUE(reading.plan);
  const std::vector<PlanStep> expected = {{false, {0, 1}, 0, 0},
                                          {true, {1, 1}, 200, 0},
                                          {false, {1, 1}, 200, 0},
                                          {true, {1, 0}, 200, -kPi / 2},
                                          {false, {2, 1}, 400, -kPi / 2}};
  EXPECT_EQ(reading.plan->steps, expected);
  EXPECT_TRUE(
      ReadActionSequence(ToActionSequence(reading.plan->steps), {}, reading.plan->start).ok());
}

TEST(DrawnPlan, TakesTheYawThatIsWritten) {
  const auto reading = ReadPlanText("[[step]]\nmove = [0, 2]\nyaw_deg = 90\n", "plan.toml");
  ASSERT_TRUE(reading.plan);
  EXPECT_DOUBLE_EQ(reading.plan->steps.at(0).yaw_rad, kPi / 2);
}

TEST(DrawnPlan, IsOnTheRedFieldIfItSaysSo) {
  const std::string steps = "start = [1, 0]\n[[step]]\nmove = [2, 0]\n";
  EXPECT_EQ(ReadPlanText("side = \"red\"\n" + steps, "p").plan->steps.at(0).height_mm, 200);
  EXPECT_EQ(ReadPlanText(steps, "p").plan->steps.at(0).height_mm, 600);
}

TEST(DrawnPlan, ReportsWhatTheRobotWouldRefuseAtItsStep) {
  const auto errors =
      Errors("start = [0, 1]\n\n[[step]]\nfetch = [1, 1]\n\n[[step]]\nfetch = [0, 2]\n");
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_THAT(errors[0], HasSubstr("plan.toml:6:"));
  EXPECT_THAT(errors[0], HasSubstr("fetch requires robot pose at current cell center"));
}

TEST(DrawnPlan, ReportsErrorsOfTheTextWithTheirPlaces) {
  EXPECT_THAT(Errors("[[step]]\nmove = [6, 0]\n").at(0), HasSubstr("plan.toml:2:9"));
  EXPECT_THAT(Errors("[[step]]\nmove = [1, 3]\n").at(0), HasSubstr("there is no column 3"));
  EXPECT_THAT(Errors("[[step]]\nmove = [1]\n").at(0), HasSubstr("expected a row and a column"));
  EXPECT_THAT(Errors("[[step]]\nmoev = [1, 0]\n").at(0), HasSubstr("plan.toml:1:1"));
  EXPECT_THAT(Errors("[[step]]\nmoev = [1, 0]\n").at(1), HasSubstr("did you mean \"move\""));
  EXPECT_THAT(Errors("[[step]]\nmove = [1, 0]\nfetch = [2, 0]\n").at(0), HasSubstr("either move"));
  EXPECT_THAT(Errors("side = \"green\"\n[[step]]\nmove = [0, 0]\n").at(0),
              HasSubstr("plan.toml:1:8"));
  EXPECT_THAT(Errors("").at(0), HasSubstr("\"step\" is missing"));
  EXPECT_THAT(Errors("step = [").at(0), HasSubstr("plan.toml:1:"));
  EXPECT_FALSE(ReadPlanFile("/nowhere/plan.toml").plan);
}

}  // namespace
}  // namespace musher::meilin::plan_file_test
