// A course for another hall: its counts, and what detectors and walker have to look for.

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "musher/modules/race/course_for_hall.hpp"
#include "musher/modules/race/toml_numbers.hpp"
#include "musher/test/modules/race/race_rig.hpp"
#include "musher/test/support/diagnostics.hpp"

namespace musher::race::hall_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string TextOf(const std::string& file) {
  std::ifstream stream(SourceDir() + "/config/" + file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

const std::string kCourse = "race/course.toml";
const std::string kSeed = "race/course_seed.toml";

Course Read(const std::string& text) {
  const CourseReading reading = ReadCourseText(text, "course.toml");
  EXPECT_THAT(musher::testing::Lines(reading.diagnostics), IsEmpty());
  return reading.course.value_or(Course{});
}

AdaptedFile For(const Hall& hall, const std::string& file = kCourse) {
  const std::string text = TextOf(file);
  return CourseForHall(hall, Read(text), text);
}

// The counts of the walks of a state, in their order.
std::vector<int> CountsOf(const Course& course, const char* name) {
  std::vector<int> counts;
  const auto state = FindByName(course.states, name);
  if (!state) return counts;
  for (const Step& step : course.states[*state].steps) {
    const auto* move = std::get_if<MoveStep>(&step);
    if (move != nullptr && course.movements[move->movement].walks) counts.push_back(move->count);
  }
  return counts;
}

int LinesThatDiffer(const std::string& one, const std::string& other) {
  std::stringstream first(one), second(other);
  int count = 0;
  for (std::string a, b; std::getline(first, a) && std::getline(second, b);) count += a != b;
  return count;
}

TEST(CourseOfAHall, ForItsOwnMeasuresIsTheCourseItself) {
  for (const std::string& file : {kCourse, kSeed}) {
    const std::string text = TextOf(file);
    const Course course = Read(text);
    EXPECT_EQ(course.hall, Hall{}) << file << " has other measures than the simulated hall";
    const AdaptedFile same = CourseForHall(course.hall, course, text);
    EXPECT_EQ(same.text, text) << file;
    EXPECT_THAT(same.changes, IsEmpty());
    EXPECT_THAT(same.open, IsEmpty());
  }
  const std::string vision = TextOf("vision/course.toml");
  EXPECT_EQ(VisionForHall({}, {}, vision).text, vision);
  const std::string walker = TextOf("line_walker/walker.toml");
  EXPECT_EQ(WalkerForHall({}, walker).text, walker);
}

TEST(CourseOfAHall, HasTheStepsOfLongerAndShorterWays) {
  Hall hall;
  hall.start_m = 1.33;        // 5.2 more steps of 0.0776 m ahead
  hall.cross_m = 2.12;        // 3.9 more ahead, and 5.2 more of 0.0582 m back
  hall.bay_a_aside_m = 0.99;  // 4.1 less aside
  hall.bay_b_aside_m = 1.52;  // 1.7 more aside, and 3.4 more from bay to bay
  const AdaptedFile file = For(hall);
  const Course course = Read(file.text);
  EXPECT_THAT(CountsOf(course, "START_TO_QRA"), ElementsAre(12 + 5, 10));
  EXPECT_THAT(CountsOf(course, "QRA_TO_A1"), ElementsAre(23 + 4, 21 - 4, 9));
  EXPECT_THAT(CountsOf(course, "S1_TO_A2"), ElementsAre(10, 18 + 4, 21 - 4, 9));
  // Back in the START lane 6.9 more of 0.0582 m: it ended 0.4 m before its start.
  EXPECT_THAT(CountsOf(course, "A1_TO_START"), ElementsAre(7, 21 - 4, 30 + 5, 10, 9 + 7));
  EXPECT_THAT(CountsOf(course, "A2_TO_START"), ElementsAre(7, 21 - 4, 30 + 5, 10, 9 + 7));
  EXPECT_THAT(CountsOf(course, "QRB_TO_B2"), ElementsAre(23 + 2, 9));
  EXPECT_THAT(CountsOf(course, "B1_TO_B2"), ElementsAre(10, 50 + 3, 9));
  EXPECT_EQ(course.hall, hall);
  EXPECT_THAT(file.changes, Contains("state.QRA_TO_A1: forward 23 -> 27 (0.30 m more)"));
  EXPECT_THAT(file.open,
              ElementsAre(HasSubstr("start_m: where the line ahead is seen from START")));
}

TEST(CourseOfAHall, WithLongerLanesWalksThemToTheirEnds) {
  Hall hall;
  hall.lane_length_m += 2;  // 25.8 steps
  const Course course = Read(For(hall).text);
  EXPECT_EQ(course.untils[FindByName(course.untils, "barrier").value()].most.count, 85 + 26);
  EXPECT_EQ(course.untils[FindByName(course.untils, "marker").value()].most.count, 85 + 26);
  for (const char* from : {"S2_TO_L1", "S2_TO_R1"}) {
    Rig rig(course);
    rig.Command("START:" + std::string(from));
    ASSERT_TRUE(rig.RunTo("IN_QRB")) << from;
    EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), 126 * 4) << from;
  }
  for (const char* from : {"B1_TO_L1", "B1_TO_R1", "B2_TO_L1", "B2_TO_R1"}) {
    Rig rig(course);
    rig.Command("START:" + std::string(from));
    ASSERT_TRUE(rig.RunTo("IN_S2_R")) << from;
    EXPECT_EQ(rig.FramesOf({0.4, 0, 0}), 133 * 4) << from;
  }
}

TEST(CourseOfAHall, OfTheDocumentHasItsStepsToo) {
  Hall hall;
  hall.lane_length_m += 0.8;
  hall.lane_aside_m += 0.06;
  const Course course = Read(For(hall, kSeed).text);
  EXPECT_THAT(CountsOf(course, "L1_TO_QRB"), ElementsAre(110, 22));
  EXPECT_EQ(course.untils[FindByName(course.untils, "barrier").value()].most.count, 110);
}

TEST(CourseOfAHall, ChangesNoOtherLineAndNoComment) {
  Hall hall;
  hall.start_m = 1.33;
  EXPECT_EQ(LinesThatDiffer(TextOf(kCourse), For(hall).text), 4)
      << "the measure, and the counts of the ways from START and back";
  EXPECT_THAT(For(hall).text, HasSubstr("start_m = 1.33           # the start to lane Q"));
}

TEST(CourseOfAHall, SaysWhatItsMeasuresDoNotGive) {
  Hall hall;
  hall.cross_m = 0.5;
  hall.s1_m = 0.5;
  const AdaptedFile file = For(hall);
  EXPECT_THAT(file.open, Contains(HasSubstr("state.A1_TO_S1: backward 24 would be 0 steps")));
  EXPECT_THAT(file.open, Contains(HasSubstr("s1_m: where the S lane is seen")));
  EXPECT_EQ(CountsOf(Read(file.text), "A1_TO_S1")[2], 24) << "no count that is none";
}

// It was left out without a word, with the exit code of a whole course.
TEST(CourseOfAHall, SaysWhichOfItsCountsIsNotFound) {
  std::string text = TextOf(kCourse);
  const std::string step = "  { move = \"forward\", count = 12 },\n";
  const std::size_t at = text.find(step);
  ASSERT_NE(at, std::string::npos);
  text.erase(at, step.size());
  Hall hall;
  hall.start_m = 1.33;
  const AdaptedFile file = CourseForHall(hall, Read(text), text);
  EXPECT_THAT(file.open, Contains("state.START_TO_QRA: its forward is not found"));
  EXPECT_THAT(CourseForHall({}, Read(text), text).open, IsEmpty()) << "none is to be changed";
}

// A state that a course does not have lacks nothing.
TEST(CourseOfAHall, OfTheDocumentLacksNoCountThatOnlyTheOtherHas) {
  Hall hall;
  hall.lane_length_m += 0.8;
  hall.bay_a_in_m += 0.1;
  hall.bay_b_aside_m += 0.1;
  EXPECT_THAT(For(hall, kSeed).open, IsEmpty());
}

TEST(VisionOfAHall, LooksForTheLinesWhereTheyAre) {
  const std::string text = TextOf("vision/course.toml");
  Hall hall;
  hall.lane_m = 0.7;
  hall.bay_a_ahead_m = 0.87;
  const AdaptedFile file = VisionForHall(hall, {}, text);
  const TomlNumbers numbers(file.text);
  EXPECT_EQ(numbers.Get({"hall", "", "lane_m"}), 0.75);
  for (const char* nearer : {"right_edge", "left_edge", "front_bay_a"}) {
    const double before = TomlNumbers(text).Get({nearer, "", "dy_target"}).value();
    EXPECT_GT(numbers.Get({nearer, "", "dy_target"}).value(), before + 0.05) << nearer;
  }
  EXPECT_LT(numbers.Get({"right_inner", "", "dy_target"}).value(), 0.5) << "farther away";
  EXPECT_EQ(numbers.Get({"front_bay", "", "dy_target"}), 0.42);
  EXPECT_THAT(file.open, IsEmpty());
}

TEST(VisionOfAHall, SaysThatALineIsOutsideOfItsRegion) {
  Hall hall;
  hall.bay_a_ahead_m = 2.5;
  EXPECT_THAT(VisionForHall(hall, {}, TextOf("vision/course.toml")).open,
              ElementsAre(HasSubstr("front_bay_a: its line, 2.5 m away, is not in its region")));
  EXPECT_THAT(VisionForHall(hall, {}, "[hall]\nlane_m = 0.88\n").open,
              ElementsAre(HasSubstr("front_bay_a: without dy_target")));
}

TEST(WalkerOfAHall, HasTheWidthOfItsLane) {
  Hall hall;
  hall.lane_m = 0.95;
  const AdaptedFile file = WalkerForHall(hall, TextOf("line_walker/walker.toml"));
  EXPECT_EQ(TomlNumbers(file.text).Get({"lane", "", "width_m"}), 0.95);
}

TEST(HallFile, KeepsTheMeasuresThatItDoesNotName) {
  Hall base;
  base.start_m = 1.5;
  const HallReading reading = ReadHallText("lane_m = 0.9\n", "hall.toml", base);
  ASSERT_TRUE(reading.hall);
  EXPECT_EQ(reading.hall->lane_m, 0.9);
  EXPECT_EQ(reading.hall->start_m, 1.5);
}

TEST(HallFile, ReportsMisspelledAndImpossibleMeasures) {
  const auto found = musher::testing::Lines(
      ReadHallText("lane_n = 0.9\nline_m = 3\n", "hall.toml", {}).diagnostics);
  EXPECT_THAT(found, Contains(HasSubstr("unknown key \"lane_n\"; did you mean \"lane_m\"?")));
  EXPECT_THAT(found, Contains(HasSubstr("hall.toml:2:")));
}

TEST(TomlNumbers, AreFoundByTableStepAndKeyAndNotInComments) {
  const std::string text =
      "# most = 1\n[until.a]\nmost = 85 # most = 3\n[state.B]\nsteps = [\n"
      "  { move = \"forward\", count = 23 },  # count = 9\n"
      "  { move = \"forward\", count = 7, beyond = 85 },\n]\n"
      "[[detectors]]\nname = \"x\"\n[detectors.parameters]\ndy_target = 0.5\n"
      "[[detectors]]\nname = \"y\"\n[detectors.parameters]\ndy_target = 0.25";
  TomlNumbers numbers(text);
  EXPECT_EQ(numbers.text(), text);
  EXPECT_EQ(numbers.Get({"until.a", "", "most"}), 85);
  EXPECT_EQ(numbers.Get({"state.B", "move = \"forward\"", "count", 1}), 7);
  EXPECT_EQ(numbers.Get({"state.B", "beyond", "beyond"}), 85);
  EXPECT_EQ(numbers.Get({"y", "", "dy_target"}), 0.25);
  EXPECT_EQ(numbers.Get({"state.B", "move = \"forward\"", "count", 2}), std::nullopt);
  EXPECT_EQ(numbers.Get({"state.C", "", "count"}), std::nullopt);
  EXPECT_TRUE(numbers.Set({"x", "", "dy_target"}, "0.75"));
  EXPECT_FALSE(numbers.Set({"z", "", "dy_target"}, "0.75"));
  EXPECT_EQ(TomlNumbers(numbers.text()).Get({"x", "", "dy_target"}), 0.75);
  EXPECT_EQ(TomlNumbers(numbers.text()).Get({"y", "", "dy_target"}), 0.25);
}

}  // namespace musher::race::hall_test
