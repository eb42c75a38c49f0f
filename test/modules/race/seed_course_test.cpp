// The course with the counts of the race's design document, config/race/course_seed.toml. The table
// is typed from section 4 of the document ("every state's actions"), in its order of the walks.

#include <gmock/gmock.h>

#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::seed_course_test {

using ::testing::ElementsAreArray;
using ::testing::IsEmpty;

using Walks = std::vector<std::pair<std::string, int>>;  // a movement, and its steps

const std::vector<std::pair<std::string, Walks>>& Document() {
  static const std::vector<std::pair<std::string, Walks>> states = {
      {"START", {}},
      {"START_TO_QRA", {{"forward", 12}, {"turn_right", 11}}},
      {"IN_QR_A", {}},
      {"QRA_TO_A1", {{"forward", 23}, {"right", 21}, {"backward", 9}}},
      {"QRA_TO_A2", {{"forward", 23}, {"left", 21}, {"backward", 9}}},
      {"IN_A1", {}},
      {"IN_A2", {}},
      {"A1_TO_S1", {{"forward", 9}, {"left", 21}, {"backward", 24}, {"turn_left", 11}}},
      {"A2_TO_S1", {{"forward", 9}, {"right", 21}, {"backward", 24}, {"turn_left", 11}}},
      {"IN_S1", {}},
      {"S1_TO_S2", {}},
      {"IN_S2", {}},
      {"S2_TO_L1", {{"left", 21}}},
      {"S2_TO_R1", {{"right", 21}}},
      {"IN_L1", {{"special_gait", 10}}},
      {"IN_R1", {}},
      {"L1_TO_QRB", {{"forward", 100}, {"right", 21}}},  // 100 - x1
      {"R1_TO_QRB", {{"forward", 100}, {"left", 21}}},   // 100 - y1
      {"IN_QRB", {}},
      {"QRB_TO_B1", {{"left", 21}, {"forward", 9}}},
      {"QRB_TO_B2", {{"right", 21}, {"forward", 9}}},
      {"IN_B1", {}},
      {"IN_B2", {}},
      {"B1_TO_B2", {{"backward", 9}, {"right", 50}, {"forward", 9}}},
      {"B2_TO_B1", {{"backward", 9}, {"left", 50}, {"forward", 9}}},
      {"B1_TO_L1", {{"turn_right", 18}}},
      {"B1_TO_R1", {{"turn_right", 18}, {"forward", 9}, {"left", 50}}},
      {"B2_TO_L1", {{"turn_right", 18}, {"forward", 9}, {"right", 50}}},
      {"B2_TO_R1", {{"turn_right", 18}}},
      {"L1_TO_S2", {{"forward", 100}, {"right", 21}}},  // 100 - x2
      {"R1_TO_S2", {{"forward", 100}, {"left", 21}}},   // 100 - y2
      {"IN_S2_R", {}},
      {"S2_TO_S1", {}},
      {"IN_S1_R", {}},
      {"S1_TO_A1", {{"turn_left", 9}, {"forward", 23}, {"right", 21}, {"backward", 9}}},
      {"S1_TO_A2", {{"turn_left", 9}, {"forward", 23}, {"left", 21}, {"backward", 9}}},
      {"A1_TO_START",
       {{"forward", 9}, {"left", 21}, {"backward", 23}, {"turn_left", 9}, {"backward", 9}}},
      {"A2_TO_START",
       {{"forward", 9}, {"right", 21}, {"backward", 23}, {"turn_left", 9}, {"backward", 9}}},
      {"END", {}},
  };
  return states;
}

// The document takes S2 to be on the other side of a robot that faces back.
std::string Mirrored(const std::string& state, const std::string& movement) {
  if (state != "L1_TO_S2" && state != "R1_TO_S2") return movement;
  return movement == "right" ? "left" : movement == "left" ? "right" : movement;
}

const CourseReading& Seed() {
  static const CourseReading reading =
      ReadCourseFile(SourceDir() + "/config/race/course_seed.toml");
  return reading;
}

Walks WalksOf(const Course& course, const StateRule& state) {
  Walks walks;
  for (const Step& step : state.steps) {
    const auto* move = std::get_if<MoveStep>(&step);
    if (move == nullptr || !course.movements[move->movement].walks) continue;
    walks.emplace_back(course.movements[move->movement].name, move->count);
  }
  return walks;
}

TEST(SeedCourse, HasNoErrors) {
  EXPECT_THAT(Seed().diagnostics, IsEmpty());
  EXPECT_TRUE(Seed().course);
}

TEST(SeedCourse, HasThe39StatesOfTheDocumentAndThoseOfTheLightAndOfFaults) {
  ASSERT_EQ(Document().size(), 39U);
  ASSERT_TRUE(Seed().course);
  std::vector<std::string> expected = {"YELLOW_LIGHT_STOP", "YELLOW_LIGHT_COUNTDOWN", "ERROR"};
  for (const auto& [name, walks] : Document()) expected.push_back(name);
  std::vector<std::string> names;
  for (const StateRule& state : Seed().course->states) names.push_back(state.name);
  EXPECT_THAT(names, ::testing::UnorderedElementsAreArray(expected));
}

TEST(SeedCourse, HasTheCountsOfTheDocumentInEveryState) {
  ASSERT_TRUE(Seed().course);
  const Course& course = *Seed().course;
  for (const auto& [name, walks] : Document()) {
    const auto state = FindByName(course.states, name);
    ASSERT_TRUE(state) << name;
    Walks expected = walks;
    for (auto& walk : expected) walk.first = Mirrored(name, walk.first);
    EXPECT_THAT(WalksOf(course, course.states[*state]), ElementsAreArray(expected)) << name;
  }
}

TEST(SeedCourse, WalksTheWholeOf100StepsBetweenS2AndTheBoardAlsoWithoutItsSight) {
  ASSERT_TRUE(Seed().course);
  for (const char* from : {"S2_TO_L1", "S2_TO_R1"}) {
    Rig rig(*Seed().course);
    rig.Command("START:" + std::string(from));
    ASSERT_TRUE(rig.RunTo("IN_QRB")) << from;
    EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), 100 * 4) << from;
  }
}

}  // namespace musher::race::seed_course_test
