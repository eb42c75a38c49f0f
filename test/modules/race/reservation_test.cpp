// What a race is not sure of: it is kept, shown at the end, and too much of it is a fault.

#include <gmock/gmock.h>

#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::reservation_test {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kCourse = R"(
start = "START"
end = "END"
error = "ERROR"
stand = "stand"
counters = ["x1"]
[detector.lines]
topic = "/lines"
type = "lines"
[detector.board]
topic = "/board"
type = "sighting"
[movement.forward]
motion = 303
twist = [0.4, 0.0, 0.0]
[movement.stand]
motion = 111
[result.qr]
values = ["A", "B"]
default = "A"
[checks]
most_given_up = 2
[check.ahead]
detector = "lines"
word = "ycy"
left = { move = "forward", count = 1 }
[wait.qr]
detector = "board"
result = "qr"
limit_ms = 1000
otherwise = "default"
[until.bar]
detector = "board"
phase = "top"
move = "forward"
most = 10
otherwise = "continue"
[speech.there]
texts = [{ zh = "到", en = "there" }]
[speech.unsure]
texts = [{ zh = "不确定", en = "unsure" }]
[state.START]
number = 0
next = "DRIVE"
[state.DRIVE]
number = 1
steps = [{ until = "bar", stores = "x1" }, { check = "ahead" }]
next = "BAY"
[state.BAY]
number = 2
steps = [{ say = "there", unsure = "unsure" }, { wait = "qr" }, { check = "ahead" }]
next = "END"
[state.END]
number = 3
[state.ERROR]
number = 46
)";

Course Small(const std::string& old = "", const std::string& with = "") {
  std::string text = kCourse;
  if (!old.empty()) text.replace(text.find(old), old.size(), with);
  const CourseReading reading = ReadCourseText(text, "small.toml");
  for (const Diagnostic& found : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(found);
  return reading.course.value_or(Course{});
}

class Doubt : public ::testing::Test {
 protected:
  static void SeeNothing(Rig& rig) {
    rig.script.lines = [](const std::string&) {
      return Lines{0, LineWord::kCenter, LineWord::kCenter};
    };
  }
  static void SeeAll(Rig& rig) {
    rig.script.lines = [](const std::string&) {
      return Lines{2, LineWord::kCenter, LineWord::kCenter};
    };
    rig.script.sight = [](const std::string&) { return Sighting{true, 1, "top", "B"}; };
  }
};

TEST_F(Doubt, IsKeptWithStateAndReasonAndShownAtTheEnd) {
  Rig rig(Small());
  SeeNothing(rig);
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("BAY"));
  EXPECT_THAT(rig.race->InfoText(), EndsWith(",TaskCompleted:False"));
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_EQ(rig.race->InfoText(),
            "CurrentState:3,QRResult:None,TaskCompleted:True,Default:qr,Reservations:4,"
            "FirstReservation:DRIVE: no bar within 10 steps,"
            "LastReservation:BAY: check ahead: no picture of it within 3000 ms");
  EXPECT_TRUE(rig.field.Logged("END: with 4 reservations:"));
  EXPECT_TRUE(rig.field.Logged("  1. DRIVE: no bar within 10 steps"));
  EXPECT_TRUE(rig.field.Logged("  2. DRIVE: check ahead: no picture of it within 3000 ms"));
  EXPECT_TRUE(rig.field.Logged("  3. BAY: no qr within 1000 ms: its default A"));
  EXPECT_TRUE(rig.field.Logged("  4. BAY: check ahead: no picture of it within 3000 ms"));
}

TEST_F(Doubt, OfADetectorIsNoWordAndItsReasonIsKept) {
  Rig rig(Small());
  SeeAll(rig);
  rig.script.lines = [](const std::string&) {
    return Lines{1, LineWord::kLeft, LineWord::kCenter, -0.2,
                 "the floor has the colour of the lines: 98 % of the region"};
  };
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_FALSE(rig.field.Logged("correction")) << "no step by what means nothing";
  EXPECT_THAT(
      rig.race->InfoText(),
      EndsWith("LastReservation:BAY: check ahead: no picture of it within 3000 ms: the floor "
               "has the colour of the lines: 98 % of the region"));
}

TEST_F(Doubt, IsNoneWhereAllIsSeen) {
  Rig rig(Small());
  SeeAll(rig);
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_THAT(rig.race->InfoText(), EndsWith(",TaskCompleted:True,Reservations:0"));
  EXPECT_TRUE(rig.field.Logged("END: without a reservation"));
}

TEST_F(Doubt, OfTooManyCorrectionsIsKept) {
  Rig rig(Small());
  SeeAll(rig);
  rig.script.lines = [](const std::string&) {
    return Lines{2, LineWord::kLeft, LineWord::kCenter};
  };
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_THAT(rig.race->InfoText(),
              HasSubstr("Reservations:2,FirstReservation:DRIVE: check ahead: left after 3 "
                        "corrections"));
}

// It was done without a word.
TEST_F(Doubt, OfAWordWithoutACorrectionIsKept) {
  Rig rig(Small());
  SeeAll(rig);
  rig.script.lines = [](const std::string&) {
    return Lines{2, LineWord::kRight, LineWord::kCenter};
  };
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_THAT(rig.race->InfoText(),
              HasSubstr("Reservations:2,FirstReservation:DRIVE: check ahead: right; for which it "
                        "has no correction"));
}

TEST_F(Doubt, OfAWordThatTheCheckAcceptsIsNone) {
  Rig rig(Small("left = { move = \"forward\", count = 1 }",
                "left = { move = \"forward\", count = 1 }\naccept = [\"right\"]"));
  SeeAll(rig);
  rig.script.lines = [](const std::string&) {
    return Lines{2, LineWord::kRight, LineWord::kCenter};
  };
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_EQ(rig.race->memory().reserved(), 0U);
}

TEST_F(Doubt, OfALineWalkerThatEndedOtherwiseIsKept) {
  Rig rig(Small("next = \"BAY\"", R"(next = "LANE"
[walk.lane]
command = "/walk"
status = "/walked"
otherwise = "continue"
[state.LANE]
number = 4
steps = [{ walk = "lane" }]
next = "BAY")"));
  SeeAll(rig);
  rig.script.walker = [](Duration walked) -> std::string {
    return walked < Milliseconds(2000) ? "State:WALKING" : "State:IDLE,Active:False,End:lost";
  };
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_THAT(
      rig.race->InfoText(),
      HasSubstr("Reservations:1,FirstReservation:LANE: the line walker has ended with lost"));
}

TEST_F(Doubt, IsForgottenByANewRun) {
  Rig rig(Small());
  SeeNothing(rig);
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("BAY"));
  SeeAll(rig);
  rig.Command("STOP");
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_THAT(rig.race->InfoText(), EndsWith(",Reservations:0"));
  rig.Command("RESET");
  EXPECT_THAT(rig.race->InfoText(), Not(HasSubstr("Reservations")));
}

TEST_F(Doubt, OfMoreChecksThanTheCourseAllowsIsAFault) {
  Rig rig(Small("most_given_up = 2", "most_given_up = 1"));
  SeeNothing(rig);
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("ERROR"));
  EXPECT_THAT(
      rig.race->InfoText(),
      HasSubstr("TaskCompleted:False,Default:qr,Reservations:4,FirstReservation:DRIVE: no bar"));
  EXPECT_THAT(rig.race->InfoText(),
              EndsWith(",Reason:BAY: 2 checks were given up, the last: check ahead in BAY: no "
                       "picture of it within 3000 ms"));
  EXPECT_TRUE(rig.field.Logged("ERROR: with 4 reservations:"));
}

TEST_F(Doubt, OfAnyNumberOfChecksIsNoFaultWithoutALimit) {
  Rig rig(Small("most_given_up = 2", "most_given_up = 0"));
  SeeNothing(rig);
  rig.Command("START");
  EXPECT_TRUE(rig.RunTo("END"));
}

TEST_F(Doubt, OfTheWayIntoABayIsSpokenInsteadOfTheArrival) {
  Rig rig(Small());
  SeeNothing(rig);
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("END"));
  EXPECT_THAT(rig.field.spoken, ElementsAre("不确定"));
  Rig sure(Small());
  SeeAll(sure);
  sure.Command("START");
  ASSERT_TRUE(sure.RunTo("END"));
  EXPECT_THAT(sure.field.spoken, ElementsAre("到"));
}

// The light's states come between the check and the bay.
TEST_F(Doubt, OfTheWayIntoABayOutlastsAYellowLight) {
  Rig rig;
  bool light = true;
  rig.script.lines = [](const std::string& detector) {
    return Lines{detector == "front_lane" ? 0U : 2U, LineWord::kCenter, LineWord::kCenter};
  };
  rig.script.sight = [&light](const std::string& detector) -> Sighting {
    return {detector == "light" && light, 0.5, "", ""};
  };
  rig.Command("START:QRB_TO_B1");
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_COUNTDOWN"));
  light = false;
  ASSERT_TRUE(rig.RunTo("IN_B1"));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.state() != "IN_B1"; }));
  EXPECT_EQ(rig.field.spoken.back(), "不确定是否已到达库位");
}

TEST_F(Doubt, IsBoundedInMemory) {
  Memory memory(TheCourse());
  for (int i = 0; i < 1000; ++i) memory.Reserve({"S", std::to_string(i)});
  EXPECT_EQ(memory.reserved(), 1000U);
  EXPECT_EQ(memory.reservations().size(), 101U);
  EXPECT_EQ(memory.reservations().front().reason, "0");
  EXPECT_EQ(memory.reservations().back().reason, "999");
}

}  // namespace musher::race::reservation_test
