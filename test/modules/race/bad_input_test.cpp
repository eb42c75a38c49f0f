// Input without sense: boards with other texts, boxes and stamps that cannot be, detectors
// that contradict each other, replies and statuses at the wrong time.

#include <gmock/gmock.h>

#include "musher/behavior/fsm/replay.hpp"
#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::bad_input_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// All detectors of sightings show this; a light is not seen.
void Show(Rig& rig, const Sighting& sighting) {
  rig.script.sight = [sighting](const std::string& detector) {
    return detector == "light" ? Sighting{false, kUnknown, "", ""} : sighting;
  };
}

std::size_t TimesLogged(const Rig& rig, std::string_view part) {
  return static_cast<std::size_t>(std::ranges::count_if(
      rig.field.log,
      [part](const std::string& line) { return line.find(part) != std::string::npos; }));
}

TEST(BadInput, ABoardWithATextThatIsNoValueIsNamedOnceAndTheDefaultIsTaken) {
  Rig rig;
  Show(rig, Text("A-3"));
  rig.Command("START:IN_QR_A");
  ASSERT_TRUE(rig.RunTo("QRA_TO_A1", std::chrono::minutes(9))) << rig.state();
  EXPECT_EQ(TimesLogged(rig, "IN_QR_A: the detector qr reads 'A-3'; there is no qr_a 'A-3'"), 1U);
}

TEST(BadInput, ABoardWithFourKilobytesIsNoSilentCamera) {
  Rig rig;
  Show(rig, Text(std::string(4096, 'A')));
  rig.Command("START:IN_QR_A");
  ASSERT_TRUE(rig.RunTo("QRA_TO_A1", std::chrono::minutes(9))) << rig.state();
  EXPECT_TRUE(rig.field.Logged("of the detector qr"));
  for (const std::string& line : rig.field.log) EXPECT_LE(line.size(), 300U) << line;
}

TEST(BadInput, ABoardWithSpacesOrADashIsReplayedIdentically) {
  for (const char* text : {"TO THE  LEFT", "-", "100% A-1", " "}) {
    Rig rig;
    Show(rig, Text(text));
    rig.Command("START:IN_QR_A");
    rig.Run(std::chrono::seconds(2));
    const auto read = fsm::ReadRecording(rig.recording, "board.record");
    ASSERT_TRUE(read) << read.error().message;
    Field field;
    fsm::Machine machine({.name = "race"});
    Race race(rig.course_, field);
    ASSERT_TRUE(race.Build(machine));
    race.Resume({});
    const auto replayed = fsm::Replay(
        read.value(), machine, [&](auto name, auto words) { return race.Apply(name, words); });
    ASSERT_TRUE(replayed) << replayed.error().message;
    EXPECT_EQ(replayed.value().difference.value_or(""), "") << text;
    EXPECT_TRUE(std::ranges::find(field.log, rig.field.log.back()) != field.log.end()) << text;
  }
}

TEST(BadInput, ABoxWithoutAPlaceIsNoBoardInTheMiddle) {
  Rig rig;
  rig.script.sight = [](const std::string& detector) {
    return Sighting{detector == "qr", 1, "", "A-1", kUnknown};
  };
  rig.Command("START:S1_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.Logged("check board"); }));
  EXPECT_TRUE(rig.field.Logged("check board: no picture of it within 3000 ms"));
}

TEST(BadInput, APictureWithAStampOfTheFutureIsNoneOfAfterTheMovement) {
  Rig rig;
  rig.script.silent = {"right_lane"};
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.Wants("right_lane"); }));
  ASSERT_TRUE(rig.field.streaming) << "opened before the end of the walk";
  const Index detector = FindByName(rig.course_.detectors, "right_lane").value();
  rig.race->OnLines(detector, 1, "left", "center", 0, rig.now + std::chrono::hours(1), rig.now);
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(20)));
  EXPECT_FALSE(rig.field.Logged("correction"));
  EXPECT_TRUE(rig.field.Logged("no sample of the detector right_lane"));
}

TEST(BadInput, ADetectorIsNotClosedBetweenAWalkAndItsCheck) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.Wants("right_lane"); }));
  while (rig.field.streaming) {
    ASSERT_TRUE(rig.Wants("right_lane"));
    rig.Tick();
  }
  EXPECT_TRUE(rig.Wants("right_lane"));
}

TEST(BadInput, ASightingOfAnUnknownDetectorChangesNothing) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  rig.Tick(3);
  for (const Index detector : {Index{999}, Index(-1)}) {
    rig.race->OnSighting(detector, Text("A-1"), rig.now, rig.now);
    rig.race->OnSighting(detector, Text(std::string(4096, 'A')), rig.now, rig.now);
    rig.race->OnSighting(detector, {true, -1, "", "A-1"}, rig.now, rig.now);
    rig.race->OnLines(detector, 1, "left", "left", 0, rig.now, rig.now);
    rig.race->OnLines(detector, 1, "up", "down", 0, rig.now, rig.now);
    rig.race->OnWalkerStatus(detector, "x,End:lost", rig.now);
  }
  rig.Run(Milliseconds(500));
  EXPECT_EQ(rig.state(), "IN_QR_A");
}

TEST(BadInput, LinesWithOtherWordsNameTheirDetector) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  const Index detector = FindByName(rig.course_.detectors, "front_lane").value();
  rig.race->OnLines(detector, 1, "up", "center", 0, rig.now, rig.now);
  EXPECT_TRUE(rig.field.Logged("a picture of the detector front_lane is refused: 'up' and"));
}

TEST(BadInput, TwoArrowsThatDisagreeAreNoDirection) {
  Rig rig;
  Show(rig, {true, 1.0, "", ""});  // as the vision module reports them
  rig.Command("START:IN_S2");
  rig.Run(std::chrono::seconds(3));
  EXPECT_EQ(rig.state(), "IN_S2");
  EXPECT_FALSE(rig.field.Logged("reads"));
  Show(rig, Text("left"));
  EXPECT_TRUE(rig.RunTo("S2_TO_L1", std::chrono::seconds(5)));
}

TEST(BadInput, AStatusOfTheWalkerWithoutSenseIsShortAndPrintableInTheReason) {
  Rig rig;
  rig.script.walker = [](Duration walked) -> std::string {
    return walked < Milliseconds(2000) ? "State:WALKING" : ",End:a\nb\x01" + std::string(900, 'z');
  };
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(12)));
  const std::string info = rig.race->InfoText();
  EXPECT_THAT(info, HasSubstr("the line walker has ended with a?b?z"));
  EXPECT_THAT(info, Not(HasSubstr("\n")));
  EXPECT_LE(info.size(), 350U) << "with a reservation of the retry";
}

TEST(BadInput, AValueThatIsRubbishIsRefusedWithTheValuesThatThereAre) {
  for (const std::string& rubbish :
       {std::string("SET_QR_A:"), std::string("SET_QR_A:\x01\xff"), std::string("SET_QR_A:a-3"),
        "SET_QR_A:" + std::string(180, 'x'), std::string("SET_QR_A:A-1:A-2")}) {
    Rig rig;
    rig.Command("START:IN_QR_A");
    rig.Command(rubbish);
    rig.Run(Milliseconds(500));
    EXPECT_EQ(rig.state(), "IN_QR_A");
    EXPECT_TRUE(rig.field.Logged("here are A-1 and A-2")) << rubbish;
    for (const std::string& line : rig.field.log) {
      EXPECT_TRUE(std::ranges::none_of(line, [](unsigned char c) { return c < ' '; })) << line;
    }
  }
}

TEST(BadInput, ACommandWithControlCharactersIsLoggedWithoutThem) {
  Rig rig;
  rig.Command("GO\x1b[2J\nrace: fault: forged");
  ASSERT_FALSE(rig.field.log.empty());
  for (const unsigned char c : rig.field.log.back()) EXPECT_GE(c, ' ') << rig.field.log.back();
}

// A word is ASCII, also on ARM, where char has no sign.
TEST(BadInput, APhaseWithBytesOutsideOfAsciiIsLeftOut) {
  for (const char* phase : {"dis\xc3\xa9", "\xff", "\x7f", "a b", "a\tb"}) {
    Rig rig;
    rig.race->OnSighting(0, {true, 1, phase, "A-1"}, rig.now, rig.now);
    EXPECT_TRUE(rig.field.Logged("counts without its phase, which is no word")) << phase;
  }
  Rig rig;
  rig.race->OnSighting(0, {true, 1, "disappeared", "A-1"}, rig.now, rig.now);
  EXPECT_FALSE(rig.field.Logged("counts without its phase"));
}

// An emergency stop reaches the motion manager and the walker, too: what they report of it may
// arrive before the pause.
TEST(BadInput, AMotionThatFailsJustBeforeAPauseIsRepeatedAfterIt) {
  for (const int ticks : {0, 1, 2, 3}) {
    Rig rig;
    rig.script.motion_replies = false;
    rig.Command("START:IN_A1");
    ASSERT_TRUE(rig.RunUntil([&] { return rig.field.motions.size() == 1; }));
    rig.race->OnMotionDone(rig.field.calls.front(), Error{3003, "emergency stop"}, rig.now);
    rig.field.calls.clear();
    rig.Tick(ticks);
    EXPECT_EQ(rig.state(), "IN_A1");
    rig.race->Pause(rig.now);
    rig.machine->Pause();
    rig.Run(std::chrono::seconds(5));
    rig.script.motion_replies = true;
    rig.race->Resume(rig.now);
    EXPECT_TRUE(rig.RunTo("A1_TO_S1", std::chrono::minutes(1))) << ticks;
  }
}

TEST(BadInput, AWalkerThatIsStoppedJustBeforeAPauseIsStartedAgainAfterIt) {
  Rig rig;
  rig.Command("START:S1_TO_S2");
  rig.Run(Milliseconds(3000));
  rig.race->OnWalkerStatus(0, "State:IDLE,Active:False,End:stopped", rig.now);
  rig.script.walker = [](Duration) { return std::string(); };
  rig.Tick(3);
  EXPECT_EQ(rig.state(), "S1_TO_S2");
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(std::chrono::seconds(5));
  rig.script.walker = [](Duration walked) -> std::string {
    return walked < Milliseconds(8000) ? "State:WALKING" : "State:IDLE,End:course_end";
  };
  rig.race->Resume(rig.now);
  EXPECT_TRUE(rig.RunTo("IN_S2", std::chrono::minutes(1))) << rig.race->InfoText();
}

// A service without a server refuses within the call.
TEST(BadInput, AMotionThatFailsWithinItsCallLeadsToTheError) {
  class Refusing : public Field {
   public:
    void Move(std::int32_t motion_id, std::uint64_t number) override {
      Field::Move(motion_id, number);
      calls.clear();
      race->OnMotionDone(number, Error{3002, "no server"}, Time(Milliseconds(2000)));
    }
    Race* race = nullptr;
  };
  Refusing field;
  fsm::Machine machine({.name = "race"});
  Race race(TheCourse(), field);
  field.race = &race;
  ASSERT_TRUE(race.Build(machine));
  Time now(Milliseconds(1000));
  race.Resume(now);
  ASSERT_TRUE(machine.Start(now));
  race.OnCommand("START", now);
  for (int i = 0; i < 200; ++i) {
    now += Milliseconds(50);
    machine.RunOnce(now);
    race.AfterTick();
  }
  EXPECT_EQ(race.state(), "ERROR");
  EXPECT_THAT(race.InfoText(), HasSubstr("the motion stand (111) failed: 3002"));
  EXPECT_THAT(field.motions, ElementsAre(111, 101));
}

// The robot is paused in every state, early and late in it, for longer than every limit.
TEST(BadInput, APauseInEveryStateIsQuietAndTheStateIsLeftAfterIt) {
  const Course& course = TheCourse();
  for (Index i = 0; i < course.states.size(); ++i) {
    const StateRule& state = course.states[i];
    if (i == course.start || i == course.end || i == course.error || state.transitions.empty())
      continue;
    if (state.transitions[0].to == kInterrupted) continue;  // only a light leads there
    for (int tick = 1; tick < 700; tick += 67) {
      Rig rig;
      Show(rig, {true, 1, "top", "left"});
      rig.Command("SET_QR_A:A-1");
      rig.Command("SET_QR_B:B-2");
      rig.Command("START:" + state.name);
      rig.Tick(tick);
      if (rig.state() != state.name) break;
      rig.race->Pause(rig.now);
      rig.machine->Pause();
      ASSERT_FALSE(rig.field.streaming || rig.field.walking_lane) << state.name << tick;
      ASSERT_TRUE(std::ranges::none_of(rig.field.watched, [](bool on) { return on; }));
      const std::size_t frames = rig.field.frames.size(), motions = rig.field.motions.size();
      rig.Run(std::chrono::seconds(55));  // within robot.resume_within_ms
      ASSERT_EQ(rig.field.frames.size(), frames) << state.name << tick;
      ASSERT_EQ(rig.field.motions.size(), motions) << state.name << tick;
      rig.race->Resume(rig.now);
      const bool left = rig.RunUntil([&] { return rig.state() != state.name; },
                                     LongestStay(course, i) + std::chrono::seconds(30));
      ASSERT_TRUE(left) << state.name << " after " << tick << " ticks";
      ASSERT_NE(rig.state(), "ERROR") << tick << " ticks: " << rig.race->InfoText();
    }
  }
}

}  // namespace musher::race::bad_input_test
