// The yellow light over a lane: it stops movements ahead, once.

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::light_test {

using ::testing::ElementsAre;

class Lamp : public Rig {
 public:
  explicit Lamp(const Course& course = TheCourse()) : Rig(course) {
    script.sight = [this](const std::string& detector) -> Sighting {
      if (detector != "light") return {false, kUnknown, "", ""};
      return {seen, distance_m, "tracking", ""};
    };
  }
  bool seen = false;
  double distance_m = 0.5;
};

TEST(YellowLight, StopsAMovementAheadWhichContinuesWithItsRestAfterTheCountdown) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  EXPECT_FALSE(rig.field.streaming);
  ASSERT_TRUE(rig.RunTo("QRA_TO_A1", Milliseconds(8000)));
  EXPECT_THAT(rig.field.spoken, ElementsAre("五", "四", "三", "二", "一"));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 2; }));
  const int frames = rig.field.frames_of_stream[0] + rig.field.frames_of_stream[1];
  EXPECT_GE(frames, 23 * 4);
  EXPECT_LE(frames, 23 * 4 + 1);
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_THAT(rig.visited, ElementsAre("QRA_TO_A1", "YELLOW_LIGHT_STOP", "YELLOW_LIGHT_COUNTDOWN",
                                       "QRA_TO_A1", "IN_A1"));
  // The way there decides, not the light.
  ASSERT_TRUE(rig.RunTo("A1_TO_S1"));
}

TEST(YellowLight, ThatIsFarStopsNothing) {
  Lamp rig;
  rig.seen = true;
  rig.distance_m = 0.71;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(4000));
  EXPECT_EQ(rig.state(), "QRA_TO_A1");
}

// A detector without a lens: the robot walked into the light.
TEST(YellowLight, OfUnknownDistanceIsNear) {
  for (const double distance_m : {kUnknown, -1.0}) {
    Lamp rig;
    rig.Command("START:QRA_TO_A1");
    rig.Run(Milliseconds(2000));
    rig.seen = true;
    rig.distance_m = distance_m;
    EXPECT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300))) << distance_m;
  }
}

// The watch stayed disarmed for the rest of the run.
TEST(YellowLight, StopsAgainWhereACommandHasLedOutOfItsState) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  rig.Command("START:L1_TO_QRB");
  ASSERT_EQ(rig.state(), "L1_TO_QRB");
  EXPECT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(2000)));
}

TEST(YellowLight, StopsAMovementWhileNoPictureComes) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  ASSERT_TRUE(rig.field.streaming);
  rig.script.cameras = false;
  rig.Run(Milliseconds(1100));
  EXPECT_FALSE(rig.field.streaming);
  rig.Run(Milliseconds(3000));
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_TRUE(rig.field.Logged("no picture for the detector light for 1000 ms"));
  rig.script.cameras = true;
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 2; }));
  const int frames = rig.field.frames_of_stream[0] + rig.field.frames_of_stream[1];
  EXPECT_GE(frames, 23 * 4);
  EXPECT_LE(frames, 23 * 4 + 1);
  EXPECT_TRUE(rig.RunTo("IN_A1"));
}

// Aside, back and in a turn it walked on without a camera.
TEST(YellowLight, NeedsItsPicturesInEveryWalkOfItsStates) {
  const std::vector<std::pair<const char*, Twist>> walks = {
      {"QRB_TO_B1", {0, 0.3, 0}}, {"B1_TO_B2", {-0.3, 0, 0}}, {"B1_TO_L1", {0, 0, -0.9}}};
  for (const auto& [state, twist] : walks) {
    Lamp rig;
    rig.seen = true;  // it does not stop these
    rig.Command("START:" + std::string(state));
    ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; })) << state;
    ASSERT_EQ(rig.field.frames.back().twist, twist);
    rig.Run(Milliseconds(500));
    ASSERT_TRUE(rig.field.streaming) << state;
    rig.script.silent = {"light"};
    rig.Run(Milliseconds(1200));
    EXPECT_FALSE(rig.field.streaming) << state;
    rig.script.silent.clear();
    rig.Run(Milliseconds(300));
    EXPECT_TRUE(rig.field.streaming) << state;
  }
}

TEST(YellowLight, NeedsItsPicturesInACorrection) {
  Lamp rig;
  rig.script.lines = [](const std::string& detector) {
    return Lines{2, detector == "right_lane" ? LineWord::kLeft : LineWord::kCenter,
                 LineWord::kCenter};
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 1; }));
  rig.script.silent = {"light"};
  rig.Run(Milliseconds(5000));
  EXPECT_LE(rig.field.streams, 2) << "the last picture permits a second";
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
}

TEST(YellowLight, WithoutPicturesForTenSecondsLeadsToTheError) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.script.cameras = false;
  EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(10'100)));
}

// Pictures of any age counted: it walked ahead by some that were a minute old.
TEST(YellowLight, IsNotLookedForInOldPictures) {
  Lamp rig;
  rig.script.picture_age = std::chrono::seconds(60);
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(5000));
  EXPECT_EQ(rig.field.streams, 0);
  EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(7000)));
  EXPECT_TRUE(rig.field.Logged("no sample of the detector light for 10000 ms"));
}

TEST(YellowLight, StopsAMovementWhileThePicturesStandStill) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  ASSERT_TRUE(rig.field.streaming);
  rig.script.picture_taken = rig.now;
  rig.Run(Milliseconds(1100));
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_TRUE(rig.field.Logged("no picture for the detector light for 1000 ms"));
  rig.script.picture_taken.reset();
  rig.Run(Milliseconds(300));
  EXPECT_TRUE(rig.field.streaming);
  rig.script.picture_taken = rig.now;
  EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(10'300)));
}

// The time of a stamp is computed by two clocks that are read one after the other, so that the same
// stamp gives another nanosecond each time: no picture was ever a repeated one.
TEST(YellowLight, StopsAMovementWhileThePicturesStandStillByTwoClocks) {
  for (const Duration ahead : {Duration(0), Duration(std::chrono::seconds(30))}) {
    Lamp rig;
    rig.script.picture_age = -ahead;
    rig.Command("START:L1_TO_QRB");
    rig.Run(Milliseconds(2000));
    ASSERT_TRUE(rig.field.streaming);
    const Time taken = rig.now + ahead;
    std::int64_t ns = 0;
    rig.script.sight = [&](const std::string&) {
      ns = (ns + 1'000) % 7'000;
      rig.script.picture_taken = taken + Duration(ns);
      return Sighting{false, kUnknown, "", ""};
    };
    rig.script.picture_taken = taken;
    rig.Run(Milliseconds(1200));
    EXPECT_FALSE(rig.field.streaming) << "ahead by " << ToSeconds(ahead) << " s";
    EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(10'300)));
  }
}

TEST(YellowLight, StopsTheLineWalkerWhileThePicturesStandStill) {
  Lamp rig;
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.script.picture_taken = rig.now;
  rig.Run(Milliseconds(1200));
  EXPECT_FALSE(rig.field.walking_lane);
}

// Each late picture counted for the detector: it stood for ever, without a word.
TEST(YellowLight, LeadsToTheErrorWhereAllPicturesAreLateForTenSeconds) {
  for (const char* state : {"QRA_TO_A1", "S1_TO_S2"}) {
    Lamp rig;
    rig.script.picture_age = Milliseconds(1500);
    rig.Command("START:" + std::string(state));
    rig.Run(std::chrono::seconds(9));
    EXPECT_EQ(rig.state(), state);
    EXPECT_EQ(rig.field.streams, 0);
    EXPECT_THAT(rig.field.walker, ::testing::IsEmpty());
    EXPECT_TRUE(rig.field.Logged("no picture for the detector light for 1000 ms"));
    EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(3000)));
    EXPECT_TRUE(rig.field.Logged("all pictures for the detector light are older than 1000 ms"));
  }
}

TEST(YellowLight, HasTenSecondsForEachTimeOfLatePictures) {
  Lamp rig;
  rig.Command("START:L1_TO_QRB");
  for (int times = 0; times < 3; ++times) {
    ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }, Milliseconds(3000))) << times;
    rig.script.picture_age = Milliseconds(1500);
    rig.Run(std::chrono::seconds(7));
    EXPECT_EQ(rig.state(), "L1_TO_QRB");
    EXPECT_FALSE(rig.field.streaming);
    rig.script.picture_age = Milliseconds(60);
  }
}

// While it corrects its place, too.
TEST(YellowLight, IsNotLookedForInOldPicturesInACorrectionAhead) {
  Lamp rig;
  rig.script.lines = [](const std::string& detector) {
    return Lines{2, detector == "right_lane" ? LineWord::kRight : LineWord::kCenter,
                 LineWord::kCenter};
  };
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.Logged("correction 1: forward"); }));
  const int streams = rig.field.streams;
  rig.script.picture_age = Milliseconds(1500);
  rig.Run(Milliseconds(3000));
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_LE(rig.FramesOf({0.4, 0, 0}), 23 * 4 + 2) << "it walks by old pictures";
  rig.script.picture_age = Milliseconds(60);
  rig.Run(Milliseconds(500));
  EXPECT_GT(rig.field.streams, streams);
}

TEST(YellowLight, StopsOnlyMovementsAhead) {
  Lamp rig;
  rig.seen = true;
  rig.Command("START:B1_TO_L1");  // stands up and turns
  rig.Run(Milliseconds(3000));
  EXPECT_TRUE(rig.field.streaming);
  EXPECT_TRUE(rig.Wants("light"));
  EXPECT_EQ(rig.state(), "B1_TO_L1");
}

// The document has it in all states with a movement ahead.
TEST(YellowLight, IsWatchedUnderTheBar) {
  Lamp rig;
  rig.Command("START:IN_L1");
  rig.Run(Milliseconds(1500));
  ASSERT_TRUE(rig.field.streaming);
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  ASSERT_TRUE(rig.RunTo("L1_TO_QRB", std::chrono::seconds(20)));
  EXPECT_GE(rig.FramesOf({0.2, 0, 0}), 10 * 4) << "it continues with its rest";
  EXPECT_LE(rig.FramesOf({0.2, 0, 0}), 10 * 4 + 1);
}

// light = true of the states of the S lane was accepted and ignored.
TEST(YellowLight, StopsTheLineWalkerWhichWalksOnAfterTheCountdown) {
  Lamp rig;
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(Milliseconds(3000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
  ASSERT_TRUE(rig.RunTo("S1_TO_S2", Milliseconds(8000)));
  EXPECT_THAT(rig.field.spoken, ElementsAre("五", "四", "三", "二", "一"));
  rig.Run(Milliseconds(500));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP", "START"));
  ASSERT_TRUE(rig.RunTo("IN_S2", std::chrono::seconds(20)));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP", "START", "STOP"));
  EXPECT_EQ(rig.field.streams, 0) << "the race itself does not walk";
}

TEST(YellowLight, StopsTheLineWalkerWhileNoPictureComes) {
  Lamp rig;
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(Milliseconds(2000));
  rig.script.cameras = false;
  rig.Run(Milliseconds(1200));
  EXPECT_FALSE(rig.field.walking_lane);
  EXPECT_TRUE(rig.field.Logged("no picture for the detector light for 1000 ms"));
  rig.script.cameras = true;
  rig.Run(Milliseconds(300));
  EXPECT_TRUE(rig.field.walking_lane);
  EXPECT_TRUE(rig.RunTo("IN_S2", std::chrono::seconds(20)));
}

// The good end was dropped, and a START followed: it walked on from behind the lane's end.
TEST(YellowLight, ThatIsSeenAtTheEndOfTheLaneStopsNothingAnyMore) {
  Lamp rig;
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(Milliseconds(2000));
  rig.seen = true;
  const Index light = FindByName(rig.course_.detectors, "light").value();
  rig.race->OnSighting(light, rig.script.sight("light"), rig.now, rig.now);
  rig.race->OnWalkerStatus(0, "State:IDLE,Active:False,End:course_end", rig.now);
  rig.script.walker = [](Duration) { return std::string(); };
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "IN_S2");
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
}

TEST(YellowLight, WithoutAPictureAtTheEndOfTheLaneStopsNothingAnyMore) {
  Lamp rig;
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(Milliseconds(2000));
  rig.script.picture_taken = rig.now;
  rig.Run(Milliseconds(1000));
  ASSERT_TRUE(rig.field.walking_lane);
  rig.race->OnWalkerStatus(0, "State:IDLE,Active:False,End:course_end", rig.now);
  rig.script.walker = [](Duration) { return std::string(); };
  rig.Tick(3);
  EXPECT_EQ(rig.state(), "IN_S2");
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
}

Course WithALightThatLiesDown() {
  std::ifstream file(CourseFile());
  std::stringstream read;
  read << file.rdbuf();
  std::string text = read.str();
  const std::string steps = "steps = [{ wait = \"light\" }]";
  const std::size_t at = text.find(steps);
  EXPECT_NE(at, std::string::npos);
  text.replace(at, steps.size(), "steps = [{ move = \"lie_down\" }, { wait = \"light\" }]");
  const CourseReading reading = ReadCourseText(text, "course.toml");
  for (const Diagnostic& found : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(found);
  return reading.course.value_or(Course{});
}

// The line walker got its START while the robot lay.
TEST(YellowLight, WhoseStateLiesDownIsFollowedByStandingUpBeforeTheLine) {
  Lamp rig(WithALightThatLiesDown());
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(Milliseconds(2000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  rig.seen = false;
  ASSERT_TRUE(rig.RunTo("S1_TO_S2", std::chrono::seconds(30)));
  EXPECT_THAT(rig.field.motions, ElementsAre(111, 101));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  EXPECT_THAT(rig.field.motions, ElementsAre(111, 101, 111));
  EXPECT_TRUE(rig.RunTo("IN_S2", std::chrono::seconds(20)));
}

// The limit of the walk counts over the stop.
TEST(YellowLight, DoesNotGiveTheLineWalkerItsTimeOnceMore) {
  Lamp rig;
  rig.script.walker = [](Duration) { return "State:WALKING,Active:True"; };
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(std::chrono::seconds(40));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  rig.seen = false;
  ASSERT_TRUE(rig.RunTo("S1_TO_S2", Milliseconds(8000)));
  EXPECT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(22)));
}

// It said "no picture for the detector light" at the begin of walks: its detector had to start.
TEST(YellowLight, IsNoFaultWhileItsDetectorStarts) {
  Lamp rig;
  rig.script.silent = {"light"};
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.Wants("light"); }));
  rig.Run(Milliseconds(3000));
  EXPECT_FALSE(rig.field.streaming) << "it does not walk blindly";
  rig.script.silent.clear();
  rig.Run(Milliseconds(300));
  EXPECT_TRUE(rig.field.streaming);
  EXPECT_FALSE(rig.field.Logged("no picture for the detector light"));
  EXPECT_TRUE(rig.RunTo("IN_A1"));
}

TEST(YellowLight, HasItsDetectorStartedBeforeTheMovementAhead) {
  Lamp rig;
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("START_TO_QRA"));
  EXPECT_TRUE(rig.RunUntil([&] { return rig.Wants("light"); }));
  EXPECT_EQ(rig.field.streams, 0);
}

TEST(YellowLight, StopsAgainOnlyAfterTwoSecondsOutOfSight) {
  Lamp rig;
  rig.Command("START:L1_TO_QRB");
  rig.Run(Milliseconds(1000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
  ASSERT_TRUE(rig.RunTo("L1_TO_QRB", Milliseconds(8000)));
  rig.Run(Milliseconds(1000));
  rig.seen = false;
  rig.Run(Milliseconds(1500));
  rig.seen = true;
  rig.Run(Milliseconds(500));
  EXPECT_EQ(rig.state(), "L1_TO_QRB");
  rig.seen = false;
  rig.Run(Milliseconds(2300));
  rig.seen = true;
  EXPECT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(300)));
}

TEST(YellowLight, StopsAgainAfterTenSecondsInSight) {
  Lamp rig;
  rig.seen = true;
  rig.Command("START:L1_TO_QRB");
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(1500)));
  ASSERT_TRUE(rig.RunTo("L1_TO_QRB", Milliseconds(8000)));
  const Time again = rig.now;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP", Milliseconds(12'000)));
  EXPECT_GE(rig.now - again, Milliseconds(9900));
}

TEST(YellowLight, DoesNotCountTheStepsUntilTheBarrierTwice) {
  Lamp rig;
  int frames = 0;
  rig.script.sight = [&](const std::string& detector) -> Sighting {
    frames = 0;
    for (const int stream : rig.field.frames_of_stream) frames += stream;
    if (detector == "light") return {frames >= 21 * 4 + 40 && frames < 21 * 4 + 60, 0.5, "", ""};
    return {true, 1, detector == "barrier" && frames >= 21 * 4 + 120 ? "top" : "seen", ""};
  };
  rig.Command("START:S2_TO_L1");
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_STOP"));
  ASSERT_TRUE(rig.RunTo("IN_L1"));
  EXPECT_TRUE(rig.field.Logged("S2_TO_L1: barrier after 30 steps"));
  EXPECT_TRUE(rig.RunTo("L1_TO_QRB"));
}

TEST(YellowLight, StaysInterruptedOverAPause) {
  Lamp rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.seen = true;
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_COUNTDOWN", Milliseconds(2000)));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(std::chrono::seconds(5));
  rig.race->Resume(rig.now);
  EXPECT_TRUE(rig.RunTo("IN_A1"));
  const int frames = rig.field.frames_of_stream[0] + rig.field.frames_of_stream[1];
  EXPECT_GE(frames, 23 * 4);
  EXPECT_LE(frames, 23 * 4 + 1);
}

TEST(YellowLight, WithoutAnInterruptedMovementLeadsToTheError) {
  Lamp rig;
  rig.Command("START:38");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
  EXPECT_TRUE(rig.field.Logged("no movement was interrupted"));
}

}  // namespace musher::race::light_test
