// Courses, read and checked.

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>
#include <utility>

#include "musher/test/modules/race/race_rig.hpp"

#include "musher/test/support/diagnostics.hpp"

namespace musher::race::course_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string TextOf(const std::string& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::string Shipped() {
  return TextOf(CourseFile());
}

// The diagnostics of the shipped course with `old` replaced by `with`.
std::vector<std::string> Faults(const std::string& old, const std::string& with) {
  std::string text = Shipped();
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  if (at == std::string::npos) return {};
  text.replace(at, old.size(), with);
  return musher::testing::Lines(ReadCourseText(text, "course.toml").diagnostics);
}

const StateRule& State(const Course& course, const char* name) {
  return course.states[FindByName(course.states, name).value()];
}

// A golden file has the diagnostics of a course with errors.
void ExpectGolden(const std::string& name) {
  const std::string folder = SourceDir() + "/test/modules/race/courses/";
  std::string found;
  for (const Diagnostic& fault :
       ReadCourseText(TextOf(folder + name + ".toml"), name + ".toml").diagnostics) {
    found += FormatDiagnostic(fault) + "\n";
  }
  EXPECT_EQ(found, TextOf(folder + name + ".txt")) << folder << name << ".txt";
}

TEST(CourseFile, HasNoTopicThatAnotherRobotOfTheDomainHas) {
  const Course& course = TheCourse();
  for (const Detector& detector : course.detectors) {
    EXPECT_NE(detector.topic.front(), '/') << detector.name;
  }
  for (const LaneWalk& walk : course.walks) {
    EXPECT_NE(walk.command.front(), '/') << walk.name;
    EXPECT_NE(walk.status.front(), '/') << walk.name;
  }
}

TEST(CourseFile, HasTheNumbersAndNamesOfAllStates) {
  const Course& course = TheCourse();
  std::map<int, std::string> names;
  for (const StateRule& state : course.states) names[state.number] = state.name;
  ASSERT_EQ(names.size(), 42U);
  for (int i = 0; i <= 39; ++i) EXPECT_TRUE(names.contains(i)) << i;
  EXPECT_EQ(names[0], "START");
  EXPECT_EQ(names[17], "R1_TO_QRB");
  EXPECT_EQ(names[31], "IN_S2_R");
  EXPECT_EQ(names[37], "A2_TO_START");
  EXPECT_EQ(names[39], "YELLOW_LIGHT_COUNTDOWN");
  EXPECT_EQ(names[45], "END");
  EXPECT_EQ(names[46], "ERROR");
}

TEST(CourseFile, HasTheTwistOfEachMovement) {
  const Course& course = TheCourse();
  const auto twist = [&](const char* name) {
    return course.movements[FindByName(course.movements, name).value()].twist;
  };
  EXPECT_EQ(twist("forward"), (Twist{0.4, 0, 0}));
  EXPECT_EQ(twist("backward"), (Twist{-0.3, 0, 0}));
  EXPECT_EQ(twist("right"), (Twist{0, -0.3, 0}));
  EXPECT_EQ(twist("left"), (Twist{0, 0.3, 0}));
  EXPECT_EQ(twist("turn_right"), (Twist{0, 0, -0.9}));
  EXPECT_EQ(twist("turn_left"), (Twist{0, 0, 0.9}));
}

TEST(CourseFile, IsChangedInItsNumbersWithoutCompiling) {
  std::string text = Shipped();
  const std::string old = "count = 23, less = \"z1\"";
  text.replace(text.find(old, text.find("[state.QRA_TO_A1]")), old.size(),
               "count = 25, less = \"z1\"");
  const CourseReading reading = ReadCourseText(text, "course.toml");
  ASSERT_TRUE(reading.course);
  const auto& step = std::get<MoveStep>(State(*reading.course, "QRA_TO_A1").steps[0]);
  EXPECT_EQ(step.count, 25);
}

TEST(CourseFile, HasAnotherBayWithoutCompiling) {
  std::string text = Shipped();
  const auto change = [&text](const std::string& old, const std::string& with) {
    text.replace(text.find(old), old.size(), with);
  };
  change("values = [\"A-1\", \"A-2\"]", "values = [\"A-1\", \"A-2\", \"A-3\"]");
  change("{ result = \"qr_a\", is = \"A-2\", to = \"QRA_TO_A2\" },",
         "{ result = \"qr_a\", is = \"A-2\", to = \"QRA_TO_A2\" },\n"
         "  { result = \"qr_a\", is = \"A-3\", to = \"IN_A3\" },");
  text += "\n[state.IN_A3]\nnumber = 50\nsteps = [{ move = \"lie_down\" }]\nnext = \"A2_TO_S1\"\n";
  const CourseReading reading = ReadCourseText(text, "course.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.course);
  Rig rig(*reading.course);
  rig.Command("START:IN_QR_A");
  rig.Command("SET_QR_A:A-3");
  EXPECT_TRUE(rig.RunTo("IN_A3", std::chrono::seconds(5)));
}

TEST(CourseFile, ReportsAValueWithoutATransition) {
  EXPECT_THAT(
      Faults("  { result = \"arrow\", is = \"right\", to = \"S2_TO_R1\" },\n", ""),
      ElementsAre(HasSubstr("error: state.IN_S2: has no transition in the case arrow = \"right\""),
                  HasSubstr("error: state.S2_TO_R1: is unreachable")));
}

TEST(CourseFile, ReportsAMisspelledWord) {
  EXPECT_THAT(Faults("on = 303\ntwist = [0.4", "on = 303\ntwits = [0.4"),
              ::testing::Contains(HasSubstr("unknown key \"twits\"; did you mean \"twist\"?")));
  EXPECT_THAT(Faults("next = \"IN_QR_A\"", "next = \"IN_QRA\""),
              ElementsAre(HasSubstr("there is no state 'IN_QRA'; did you mean 'IN_QR_A'?")));
  EXPECT_THAT(Faults("{ check = \"right_ycy\" }", "{ check = \"right_ycx\" }"),
              ElementsAre(HasSubstr("there is no check 'right_ycx'; did you mean 'right_ycy'?")));
}

TEST(CourseFile, ReportsCountsThatAreNone) {
  EXPECT_THAT(Faults("count = 12 }", "count = 0 }"),
              ElementsAre(HasSubstr("expected an integer from 1 to 10000 steps, found 0")));
  EXPECT_THAT(Faults("count = 12 }", "count = -3 }"),
              ElementsAre(HasSubstr("expected an integer from 1 to 10000 steps, found -3")));
  EXPECT_THAT(Faults("count = 12 }", "count = 10001 }"),
              ElementsAre(HasSubstr("expected an integer from 1 to 10000 steps, found 10001")));
}

TEST(CourseFile, ReportsConditionsOfStepsThatAreNone) {
  EXPECT_THAT(Faults("count = 10, only = \"barrier\"", "count = 10, only = \"bariere\""),
              ElementsAre(HasSubstr("there is no until 'bariere'; did you mean 'barrier'?")));
  EXPECT_THAT(Faults("by = 5, only = \"barrier\"", "by = 5, only = \"bar\""),
              ElementsAre(HasSubstr("there is no until 'bar'")));
  EXPECT_THAT(Faults("count = 15, less = \"x1\", beyond = 85 },", "count = 15, beyond = 85 },"),
              ElementsAre(HasSubstr("steps.beyond: expected less = … beside it")));
  EXPECT_THAT(Faults("{ move = \"lie_down\" }", "{ move = \"lie_down\", beyond = 85 }"),
              ElementsAre(HasSubstr("steps.beyond: lie_down is one motion, and no walk")));
  EXPECT_THAT(Faults("most = 76, s", "most = 0, s"),
              ElementsAre(HasSubstr("expected an integer from 1 to 10000 steps, found 0")));
  EXPECT_THAT(
      Faults("unsure = \"unsure_bay\" },", "unsure = \"unsure_bey\" },"),
      ElementsAre(HasSubstr("there is no speech 'unsure_bey'; did you mean 'unsure_bay'?")));
  EXPECT_THAT(
      Faults("say = \"countdown\", only = \"marker\"", "say = \"countdown\", only = \"market\""),
      ElementsAre(HasSubstr("there is no until 'market'; did you mean 'marker'?")));
}

TEST(CourseFile, ReportsAgreementsAndStepsBackThatAreNone) {
  const auto faults_of = [](const std::string& line) {
    return Faults("[check.left_ycy]\n", "[check.left_ycy]\n" + line + "\n");
  };
  EXPECT_THAT(faults_of("agrees_with = \"right_ycy\""), IsEmpty());
  EXPECT_THAT(faults_of("agrees_with = \"right_ycx\""),
              ElementsAre(HasSubstr("there is no check 'right_ycx'; did you mean 'right_ycy'?")));
  EXPECT_THAT(faults_of("agrees_with = \"left_ycy\""),
              ElementsAre(HasSubstr("expected another check, of another camera")));
  EXPECT_THAT(Faults("[check.board]\n", "[check.board]\nagrees_with = \"right_ycy\"\n"),
              ElementsAre(HasSubstr("expected a check of lines, found one of a box")));
  const auto steps_back = [](const std::string& value) {
    return Faults("[checks]\n", "[checks]\nstep_back = " + value + "\n");
  };
  EXPECT_THAT(steps_back("{ away = { move = \"backward\" }, back = { move = \"forward\" } }"),
              IsEmpty());
  EXPECT_THAT(steps_back("{ away = { move = \"backward\" } }"), ElementsAre(HasSubstr("back")));
  EXPECT_THAT(steps_back("{ away = { move = \"stand\" }, back = { move = \"forward\" } }"),
              ElementsAre(HasSubstr("stand is one motion; expected a movement with a twist")));
}

TEST(CourseFile, ReportsRulesOfDoubtAndOdometryThatAreNone) {
  EXPECT_THAT(Faults("most_given_up = 9", "most_given_up = -1"),
              ElementsAre(HasSubstr("expected an integer from 0 to 1000, found -1")));
  EXPECT_THAT(
      Faults("topic = \"odom_out\"", "topic = \"odom out\""),
      ElementsAre(HasSubstr("expected the name of a topic, as in \"odom_out\", or \"\" for none, "
                            "found \"odom out\"")));
  EXPECT_THAT(Faults("topic = \"odom_out\"", "topic = \"\""), IsEmpty());
  EXPECT_THAT(Faults("least_share = 0.8", "least_share = 1.1"),
              ElementsAre(HasSubstr("expected a number from 0.2 to 1")));
  EXPECT_THAT(Faults("odometry_share = 0.97", "odometry_share = 0"),
              ElementsAre(HasSubstr("expected a number from 0.2 to 2")));
}

TEST(CourseFile, HasTheWaitsOfTheRule) {
  const Course& course = TheCourse();
  for (const char* name : {"s1", "s2"}) {
    EXPECT_EQ(course.waits[FindByName(course.waits, name).value()].limit, Milliseconds(60'000));
  }
}

TEST(CourseFile, ReportsEveryUnknownNameAtOnce) {
  ExpectGolden("unknown_names");
}

TEST(CourseFile, ReportsEveryStateThatGetsStuck) {
  ExpectGolden("stuck");
}

TEST(CourseFile, ReportsStatesThatGetStuckBesideUnknownNames) {
  ExpectGolden("unknown_and_stuck");
}

TEST(CourseFile, ReportsStatesThatCannotBeTheSame) {
  ExpectGolden("same_states");
}

TEST(CourseFile, TakesADetectorOfWordsForAWaitAndForNothingElse) {
  const std::string sighting = "topic = \"green_arrow_detector/sighting\"\ntype = \"sighting\"";
  EXPECT_THAT(Faults(sighting, "topic = \"green_arrow_detector/direction\"\ntype = \"text\""),
              IsEmpty());
  const std::string barrier = "topic = \"red_barrier_detector/sighting\"\ntype = \"sighting\"";
  EXPECT_THAT(Faults(barrier, "topic = \"red_barrier_detector/distance\"\ntype = \"text\""),
              ElementsAre(HasSubstr("barrier is not a detector of type \"sighting\"")));
}

TEST(CourseFile, ReportsCommandsThatHideOthers) {
  ExpectGolden("hidden_commands");
}

TEST(CourseFile, ReportsATransitionBackThatNothingLeadsBackFrom) {
  std::string text = Shipped();
  const std::size_t light = text.find("[light]");
  text.erase(light, text.find("[speech.qr_a]") - light);
  std::vector<std::string> lines;
  for (const Diagnostic& fault : ReadCourseText(text, "course.toml").diagnostics) {
    lines.push_back(fault.message);
  }
  EXPECT_THAT(lines,
              ::testing::Contains(HasSubstr(
                  "state.YELLOW_LIGHT_COUNTDOWN: \"back\" leads to the movement that a light "
                  "has interrupted, and the course has no [light]")));
}

TEST(CourseFile, ReportsALightThatIsWatchedInItsOwnState) {
  EXPECT_THAT(
      Faults("[state.YELLOW_LIGHT_STOP]\n", "[state.YELLOW_LIGHT_STOP]\nlight = true\n"),
      ElementsAre(HasSubstr("state.YELLOW_LIGHT_STOP: light = true in the state of [light]")));
}

TEST(CourseFile, CutAnywhereIsReportedWithAPlace) {
  const std::string text = Shipped();
  for (std::size_t size = 0; size < text.size(); size += 397) {
    const CourseReading reading = ReadCourseText(text.substr(0, size), "course.toml");
    EXPECT_FALSE(reading.course && size < text.size() - 100) << size;
    for (const Diagnostic& fault : reading.diagnostics) {
      EXPECT_THAT(FormatDiagnostic(fault),
                  ::testing::MatchesRegex("course.toml:[0-9]+:[0-9]+: .+"));
    }
  }
}

// One line is missing at a time: nothing but errors may come of it.
TEST(CourseFile, WithoutOneOfItsLinesIsReadOrReported) {
  const std::string text = Shipped();
  constexpr int kEvery = 5;
  int line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    const std::size_t here = std::exchange(begin, end);
    if (++line % kEvery != 0) continue;
    std::string cut = text;
    cut.erase(here, end - here);
    const CourseReading reading = ReadCourseText(cut, "course.toml");
    EXPECT_TRUE(reading.course || !reading.diagnostics.empty()) << text.substr(here, end - here);
  }
}

TEST(CourseFile, ReportsNumbersThatAreTooLargeForAnything) {
  for (const char* number :
       {"1000000000", "99999999999999999999999", "1e9", "-1", "nan", "\"12\""}) {
    EXPECT_THAT(Faults("count = 12 }", "count = " + std::string(number) + " }"),
                ::testing::Contains(HasSubstr("course.toml:")))
        << number;
  }
}

TEST(CourseFile, OfNothingAsksForItsKeys) {
  std::vector<std::string> lines;
  for (const Diagnostic& fault : ReadCourseText("", "course.toml").diagnostics) {
    lines.push_back(fault.message);
  }
  EXPECT_THAT(lines, ::testing::Contains(HasSubstr("the key \"state\" is missing")));
  EXPECT_THAT(lines, ::testing::Contains(HasSubstr("the key \"start\" is missing")));
  EXPECT_THAT(ReadCourseFile("/no/such/course.toml").diagnostics, ::testing::SizeIs(1));
}

TEST(CourseFile, BuildsAMachineWithoutWarnings) {
  Rig rig;
  EXPECT_THAT(rig.machine->warnings(), IsEmpty());
}

TEST(CourseFile, IsSummarised) {
  EXPECT_THAT(Summary(TheCourse()), HasSubstr("42 states"));
}

}  // namespace musher::race::course_test
